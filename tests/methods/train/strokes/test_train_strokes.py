import copy
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.strokes.train_strokes import StrokesTraining
from caricli.models.strokes.config import StrokesConfig


@pytest.fixture(scope="module")
def data(head_template, people):
    """Stands in for a Dataset of twelve heads."""
    splits = {"train": [0, 1], "validation": [2], "test": [3]}
    identity = np.repeat(np.arange(4), 3)
    return SimpleNamespace(
        template=head_template,
        vertices=people[:12].astype(np.float32),
        rows=lambda split: np.flatnonzero(np.isin(identity, splits[split])),
    )


def begin(data, *overrides, share=ALL):
    return StrokesTraining([data], read_config(config_path("strokes/tiny.yaml"), StrokesConfig, overrides), share)


def test_it_learns(data):
    records = list(begin(data, "epochs=3", "steps=25", "batch=8", "learning_rate=1e-2").epochs())
    assert records[-1].loss < 0.9 * records[0].loss
    assert records[-1].validation_error < records[0].validation_error < 1


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(data):
    whole = begin(data)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    for number in (0, 1):
        left = begin(data)
        left.load_state(states[number])
        list(left.epochs())
        for name, value in left.average.state_dict().items():
            assert torch.equal(value, whole.average.state_dict()[name]), name


def test_places_know_what_they_draw(data):
    training = begin(data, "batch=8", "points=400")
    batch = training._draw(0)
    assert batch.windows.shape == (8, 1, 64, 64) and batch.places.shape == (8, 400, 4)
    assert set(batch.classes.unique().tolist()) <= set(range(1 + len(training.curves)))
    left, right = (1 + training.curves.index(f"brow_{side}") for side in ("left", "right"))
    columns = [batch.places[batch.classes == number][:, 0].mean() for number in (left, right)]
    assert columns[0] > columns[1]


def test_processes_share_the_sketches_of_a_batch(data):
    whole = begin(data)._draw(0)
    parts = [begin(data, share=Share(process, 2))._draw(0) for process in (0, 1)]
    for number in range(4):
        assert torch.equal(parts[number % 2].windows[number // 2], whole.windows[number])
        assert torch.equal(parts[number % 2].classes[number // 2], whole.classes[number])


def test_somebody_must_be_there(data):
    nobody = SimpleNamespace(**vars(data) | {"rows": lambda split: np.zeros(0, int)})
    with pytest.raises(InputError, match="people of the train split"):
        begin(nobody)
