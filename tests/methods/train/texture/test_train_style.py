import copy

import numpy as np
import pytest
import torch

from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.dynamic.media import NAMES
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.texture.painted_pairs import painted_pairs
from caricli.methods.train.texture.train_style import StyleTraining, local_distance, style_errors
from caricli.models.style.config import StyleConfig
from caricli.models.style.model import StyleModel


@pytest.fixture(scope="module")
def pairs(head_template):
    return painted_pairs(head_template, 6, (0, 1)), painted_pairs(head_template, 2, (0, 2))


def begin(pairs, *overrides, share=ALL, drawings=()):
    training, unseen = pairs
    config = read_config(config_path("style/tiny.yaml"), StyleConfig, overrides)
    return StyleTraining(training, unseen, drawings, config, share)


def test_pairs_show_the_same_people(pairs):
    training, unseen = pairs
    assert training.plain.shape == training.painted.shape == training.other.shape == (6, 128, 128, 3)
    assert set(training.media) <= set(range(len(NAMES)))
    assert not (training.plain[0] == unseen.plain[0]).all()


def test_it_learns(pairs):
    training = begin(pairs, "epochs=3", "steps=12")
    records = list(training.epochs())
    assert records[-1].loss < 0.8 * records[0].loss
    assert records[-1].validation_error < records[0].validation_error


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(pairs):
    whole = begin(pairs)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    for number in (0, 1):
        left = begin(pairs)
        left.load_state(states[number])
        list(left.epochs())
        for name, value in left.average.state_dict().items():
            assert torch.equal(value, whole.average.state_dict()[name]), name


def test_a_random_encoder_stays_as_it_is(pairs):
    training = begin(pairs, "encoder=random", "epochs=1")
    before = copy.deepcopy(training.network.encoder.state_dict())
    list(training.epochs())
    for name, value in training.network.encoder.state_dict().items():
        assert torch.equal(value, before[name]), name


def test_losses_of_style_do_not_move_the_encoder(pairs):
    training = begin(pairs, "again_weight=0", "medium_weight=0", "pair_weight=0")
    loss, _ = training._loss(training._draw(0))
    loss.backward()
    assert all(weight.grad is None or not weight.grad.any() for weight in training.network.encoder.parameters())
    assert all(weight.grad.any() for weight in training.network.decoder.parameters() if weight.ndim > 1)


def test_processes_share_the_windows_of_a_batch(pairs):
    whole = begin(pairs)._draw(0)
    parts = [begin(pairs, share=Share(process, 2))._draw(0) for process in (0, 1)]
    assert whole.paired.tolist() == [1, 1, 0, 0]
    for number in range(4):
        assert torch.equal(parts[number % 2].content[number // 2], whole.content[number])


def test_drawings_are_styles_that_nobody_names(pairs):
    drawing = np.full((40, 90, 3), 7, np.uint8)
    training = begin(pairs, "batch=40", drawings=[drawing])
    drawn = training._draw(0)
    black = (drawn.style * 255 == 7).all((1, 2, 3))
    assert 2 < black.sum() < 18 and not drawn.paired[black].any() and (drawn.media[black] < 0).all()


def test_errors_do_not_ask_where_strokes_are(pairs):
    stripes = torch.arange(64).remainder(4).lt(2).float().expand(1, 3, 64, 64)
    moved = stripes.roll(1, 3)
    assert local_distance(stripes, moved) < 0.25 * local_distance(stripes, torch.full_like(stripes, 0.5))
    model = StyleModel(begin(pairs).average, NAMES)
    errors = np.array(style_errors(model, pairs[1]))
    assert errors.shape == (2, 2) and (errors > 0).all()
