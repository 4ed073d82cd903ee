import copy
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.sketch.sketch_artist import WRINKLED
from caricli.methods.train.sketch.published_faces import PublishedFaces
from caricli.methods.train.sketch.train_published import PublishedTraining, Step
from caricli.methods.train.sketch.wrinkle_book import WrinkleBook
from caricli.models.bilinear.config import BilinearConfig
from caricli.models.bilinear.model import BilinearModel
from caricli.models.sketch.config import SketchConfig
from caricli.template.annotation import parse_annotation

SHORT = ("steps=2",)


@pytest.fixture(scope="module")
def data(head, head_template, people):
    """Stands in for a grid of five people with three expressions, four of them to train with."""
    smiles = [{}, {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0}, {"jawOpen": 0.6}]
    added = [head.evaluate(actions=actions) - head.evaluate() for actions in smiles]
    identity = np.repeat(np.arange(5), 3)
    return SimpleNamespace(
        template=head_template,
        vertices=np.stack([people[k] + offset for k in range(5) for offset in added]).astype(np.float32),
        identity=identity,
        expression=np.tile([0, 1, 2], 5),
        level=np.ones(15, int),
        factors={"kind": np.zeros(15, int)},
        rows=lambda split: np.isin(identity, {"train": [0, 1, 2, 3], "validation": [4], "test": []}[split]),
    )


@pytest.fixture(scope="module")
def model(head_template, data):
    grid = data.vertices[:12].astype(float).reshape(4, 3, -1, 3)
    return BilinearModel.train(head_template, grid, BilinearConfig(4, 3))


def begin(data, model, *overrides):
    config = read_config(config_path("sketch/tiny_published.yaml"), SketchConfig, overrides)
    return PublishedTraining([data], model, config)


@pytest.mark.parametrize("choice", ["kernel_rate=0.01", "variant=pixel_single"])
@pytest.mark.parametrize("left", [0, 1, 2])
def test_left_after_any_step_it_goes_on_to_the_same_bytes(data, model, choice, left):
    options = (*SHORT, choice)
    whole = begin(data, model, *options)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    again = begin(data, model, *options)
    again.load_state(states[left])
    list(again.epochs())
    for name, value in again.average.state_dict().items():
        assert torch.equal(value, whole.average.state_dict()[name]), name
    assert again.state()["counters"] == states[-1]["counters"]


def test_a_state_of_another_training_is_refused(data, model):
    state = begin(data, model, *SHORT).state()
    for broken in (state | {"counters": None}, state | {"network": {}}):
        with pytest.raises(InputError):
            begin(data, model, *SHORT).load_state(broken)


def test_every_step_learns_what_it_is_for(data, model):
    training = begin(data, model, *SHORT, "epochs=3")
    states = [copy.deepcopy(training.network.state_dict())]
    states += [copy.deepcopy(training.network.state_dict()) for _ in training.epochs()]

    def changed(step, part):
        names = [name for name in states[0] if name.startswith(part)]
        assert names, part
        return any(not torch.equal(states[step][name], states[step + 1][name]) for name in names)

    for step, parts in (
        (Step.CLASSIFY, {"convolutions": True, "kinds": True, "last": False, "of_u": True, "told_v": True}),
        (Step.REGRESS, {"convolutions": False, "kinds": False, "last": True, "of_u": True, "told_v": True}),
        (Step.TUNE, {"convolutions": True, "kinds": False, "last": True, "of_u": True, "told_v": True}),
    ):
        assert {part: changed(step, part) for part in parts} == parts, step
    assert not list(training.copied_average().kinds)


def test_all_layers_but_the_last_ones_learn_by_muon(data, model):
    training = begin(data, model, *SHORT, "kernel_rate=0.01")
    assert training.step is Step.CLASSIFY
    network = training.network
    assert len(training.muon.kernels) == 12
    assert not {id(layer.weight) for layer in (*network.last, *network.kinds)} & set(map(id, training.muon.kernels))
    list(training.epochs())
    # What sees is left as it is in the second step, and learns again in the third.
    assert training.step is Step.TUNE and len(training.muon.kernels) == 12


def test_the_last_loss_is_equation_2(data, model):
    """Beside a slow sum over the vertices, for codes that are a little off."""
    training = begin(data, model, *SHORT)
    codes = training.faces.codes[:5] + 0.1 * training.faces.codes.std(0)
    own = training._squared(torch.from_numpy(codes).float(), torch.from_numpy(training.faces.rows[:5]).float())
    weights = np.ones(len(data.template.vertices))
    weights[training.hand.ids] = training.config.importance
    weights /= weights.mean()
    core = np.tensordot(model.basis, model.space.core, (0, 0))
    u, v = model.space.parts(codes)
    rows = np.tensordot(training.faces.rows[:5], model.basis, 1)
    slow = [(weights * ((np.einsum("vaie,i,e->va", core, u[k], v[k]) - rows[k]) ** 2).sum(1)).mean() for k in range(5)]
    np.testing.assert_allclose(own.numpy(), slow, rtol=1e-3)


def test_faces_of_the_grid_come_back_from_their_rows(data, model):
    training = begin(data, model, *SHORT)
    count = len(training.faces.person)
    assert len(training.faces.codes) == count + training.config.extra
    found = np.tensordot(training.faces.rows, model.basis, 1)
    np.testing.assert_allclose(found[:, training.hand.ids], training.faces.positions, atol=2e-4)
    assert set(training.faces.expression) == {0, 1, 2} and training.faces.person.max() == 3


@pytest.mark.parametrize("rates", [("learning_rate=0.01",), ("learning_rate=0.01", "kernel_rate=0.02")])
def test_it_learns_whose_face_it_is(data, model, rates):
    options = ("epochs=8", "steps=15", "variant=shape", "held=0", "missing=0", "batch=16", *rates)
    training = begin(data, model, *options)
    start = training._validate()
    records = list(training.epochs())
    assert [record.validation_error is None for record in records[:3]] == [True, True, False]
    assert records[-1].loss < 0.75 * records[2].loss
    assert np.isfinite(start) and training.best < 2 * start


def test_wrinkles_of_heads_are_their_own(data):
    book = WrinkleBook.of(data.template, data.vertices[:3])
    lines = book.of_rows(np.array([2, 0]))
    assert lines.lines.shape[:2] == lines.there.shape and lines.there.any(1).all()
    np.testing.assert_array_equal(lines.lines[0][lines.there[0]], book.lines[book.starts[2] : book.starts[3]])
    alone = book.some(np.array([2, 0])).of_rows(np.array([0, 1]))
    np.testing.assert_array_equal(alone.lines, lines.lines)
    assert np.linalg.norm(lines.lines[0][0], axis=1).min() > 0


def test_wrinkles_kept_of_an_annotation_are_not_those_of_another(data, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    template = data.template
    source = template.annotation.source
    fewer = {name: ids for name, ids in source["regions"].items() if name not in WRINKLED}
    annotation = parse_annotation(source | {"regions": fewer}, len(template.vertices), "smooth")
    assert len(WrinkleBook.of(template, data.vertices[:1]).lines) > 0
    assert len(WrinkleBook.of(replace(template, annotation=annotation), data.vertices[:1]).lines) == 0


def test_it_is_validated_with_as_many_faces_as_are_asked_for(data, model):
    training = begin(data, model, "variant=shape")
    splits = {"train": data.identity < 2, "validation": data.identity >= 2}
    other: Any = SimpleNamespace(**vars(data) | {"rows": splits.__getitem__})
    for asked, faces in ((8, 8), (20, 9)):
        settings = replace(training.config, held=0, extra=0, validation=asked)
        unseen = PublishedFaces.of([other], model, training.hand, settings).unseen
        assert len(np.unique(unseen, axis=0)) == len(unseen) == faces
        np.testing.assert_array_equal(unseen[[0, -1]], data.vertices[[6, -1]])


def test_a_dataset_without_a_grid_is_refused(data, model):
    part: Any = SimpleNamespace(**vars(data) | {"rows": lambda split: np.arange(15) < (11 if split == "train" else 15)})
    with pytest.raises(InputError, match="grid"):
        begin(part, model)
