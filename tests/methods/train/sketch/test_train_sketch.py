import copy
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from caricli.data.held_out import held_out
from caricli.errors import InputError
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.lines.along_lines import along
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.sketch.sketch_faces import SketchFaces
from caricli.methods.train.sketch.sketch_hand import LINE, Missing, SketchHand
from caricli.methods.train.sketch.train_sketch import SketchTraining
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.models.sketch.config import SketchConfig
from caricli.template.feature_curves import feature_curves

FEW = ("epochs=3", "steps=3", "batch=8", "validate_every=1", "validation=4")


@pytest.fixture(scope="module")
def data(head_template, people):
    """Stands in for a Dataset of twelve heads: three of each of four people, the first of them at rest."""
    splits = {"train": [0, 1], "validation": [2], "test": [3]}
    identity = np.repeat(np.arange(4), 3)
    return SimpleNamespace(
        template=head_template,
        vertices=people[:12].astype(np.float32),
        identity=identity,
        expression=np.tile([0, 1, 2], 4),
        level=np.ones(12, int),
        factors={"kind": np.zeros(12, int)},
        rows=lambda split: np.isin(identity, splits[split]),
    )


@pytest.fixture(scope="module")
def model(head_template, people):
    return PcaModel.train(head_template, people, PcaConfig(6))


@pytest.fixture(scope="module")
def hand(head_template):
    return SketchHand(feature_curves(head_template.annotation), 64)


def begin(data, model, *overrides, share=ALL):
    return SketchTraining([data], model, read_config(config_path("sketch/tiny.yaml"), SketchConfig, overrides), share)


def positions(hand, people, count):
    return people[:count, hand.ids]


def test_a_steady_hand_draws_what_the_camera_sees(hand, people):
    drawn = hand.draw(positions(hand, people, 3), np.zeros(3), Missing(), np.random.default_rng(0))
    for row, vertices in enumerate(people[:3]):
        numbers = drawn.cameras[row]
        seen = np.exp(numbers[3]) * vertices @ head_rotation(numbers[:3])[:2].T + numbers[4:]
        for curve, line in zip(hand.curves, drawn.lines[row], strict=True):
            expected = along(seen[curve.vertices][None], np.linspace(0, 1, LINE)[None])[0]
            np.testing.assert_allclose(line, expected, atol=1e-9)
        assert np.abs(drawn.lines[row]).max() == pytest.approx(0.86)
    batch = hand.batch(drawn)
    assert batch.windows.shape == (3, 64, 64) and np.isfinite(batch.points).all()
    pixels = np.rint(31.5 * (1 + batch.points[0].reshape(-1, 2))).astype(int)
    assert (batch.windows[0][pixels[:, 1], pixels[:, 0]] > 0).mean() > 0.95


def test_an_unsteady_hand_is_as_far_off_as_it_is_unsteady(hand, people):
    def distance(strength):
        generators = [np.random.default_rng(3) for _ in range(2)]
        steps = [np.full(8, value) for value in (0.0, strength)]
        lines = [
            hand.draw(positions(hand, people, 8), step, Missing(), own).lines
            for step, own in zip(steps, generators, strict=True)
        ]
        return np.linalg.norm(lines[1] - lines[0], axis=-1).mean()

    assert 0.01 < distance(0.5) < distance(1.0) < distance(2.0) < 0.3


@pytest.mark.parametrize("fixed", [None, 0.5])
def test_strokes_are_missing_as_asked(hand, people, fixed):
    heads = positions(hand, people, 40)
    drawn = hand.draw(heads, np.ones(40), Missing(0.5, fixed, 0.25), np.random.default_rng(0))
    left = drawn.there.sum(1)
    curves = len(hand.curves)
    assert left.min() >= 2 and 10 <= (left == curves).sum() <= 30
    if fixed:
        assert set(left) == {curves // 2, curves}
    batch = hand.batch(drawn)
    told = np.isfinite(batch.points).all((2, 3))
    np.testing.assert_array_equal(told, drawn.there & drawn.named[:, None])
    assert 2 <= (~drawn.named).sum() <= 20
    # Only what is there is in the picture, and the window is around it.
    reach = np.where(drawn.there[..., None, None], np.abs(drawn.lines), 0).max((1, 2, 3))
    assert 0.6 < reach.min() and reach.max() < 1.3


def test_expressions_are_told_from_people(data, model):
    faces = SketchFaces.of([data], model)
    assert faces.latents.shape == (6, 6)
    rest = faces.latents - faces.offsets
    for person in (0, 1):
        own = rest[3 * person : 3 * person + 3]
        np.testing.assert_allclose(own, own[:1].repeat(3, 0), atol=1e-9)
    np.testing.assert_array_equal(faces.offsets[[0, 3]], 0)


def test_faces_that_another_dataset_holds_out_are_not_trained_with(data, model):
    # Of the same people, one with fewer of their faces.
    fewer: Any = SimpleNamespace(**vars(data) | {"rows": lambda split: data.rows(split) & (data.expression > 0)})
    alone, both = (SketchFaces.of(datasets, model, 0.34, 1) for datasets in ([data], [data, fewer]))
    held = [held_out(each, 0.34, 1) for each in (data, fewer)]
    out = {row for parts in held for name in ("validation", "test") for row in parts[name].tolist()}
    trained = [row for parts in held for row in parts["train"].tolist()]
    assert len(alone.latents) == len(held[0]["train"])
    assert len(both.latents) == len([row for row in trained if row not in out]) < len(trained)


def test_who_is_never_at_rest_has_the_usual_expression(data, model):
    other: Any = SimpleNamespace(**vars(data) | {"expression": np.array([0, 1, 2, 1, 1, 2] + [0] * 6)})
    faces = SketchFaces.of([other], model)
    np.testing.assert_allclose(faces.offsets[3:], faces.offsets[[1, 1, 2]], atol=1e-12)


def test_mixtures_are_of_nobody_and_vary_as_people_do(data, model):
    faces = SketchFaces.of([data], model)
    generator = np.random.default_rng(0)
    plain = faces.draw(50, generator, 0.0, 3)
    assert all((np.abs(faces.latents - latent).max(1) < 1e-12).any() for latent in plain)
    mixed = faces.draw(400, generator, 1.0, 3)
    apart = np.linalg.norm(mixed[:, None] - faces.latents, axis=2).min(1)
    assert (apart > 1e-3).mean() > 0.5
    spreads = [np.linalg.norm(each - each.mean(0), axis=1).mean() for each in (mixed, faces.latents)]
    assert 0.6 < spreads[0] / spreads[1] < 1.4


def test_it_learns_from_pictures_whose_face_it_is(data, model):
    training = begin(data, model, "epochs=6", "steps=20", "unnamed=1", "missing=0")
    batch, latents = training._draw(0)
    assert batch.windows.any((1, 2)).all() and np.isnan(batch.points).all()
    usual = np.linalg.norm(model.decode(latents) - model.decode(latents.mean(0)), axis=-1).mean()
    records = list(training.epochs())
    assert records[-1].loss < 0.7 * records[0].loss
    assert records[-1].train_error < 0.7 * usual


def test_what_lines_tell_linearly_it_knows_from_the_start(data, model):
    training = begin(data, model, "epochs=6", "steps=20", "unnamed=0", "missing=0")
    drawn = training._draw(0)
    assert not drawn[0].windows.any() and np.isfinite(drawn[0].points).all()
    usual = np.linalg.norm(model.decode(drawn[1]) - model.decode(drawn[1].mean(0)), axis=-1).mean()
    assert float(training._loss(drawn)[1].detach()) < 0.35 * usual


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(data, model):
    whole = begin(data, model, *FEW)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    left = begin(data, model, *FEW)
    left.load_state(states[0])
    list(left.epochs())
    for name, value in left.average.state_dict().items():
        assert torch.equal(value, whole.average.state_dict()[name]), name
    assert left.state()["counters"] == states[-1]["counters"]


def test_processes_share_the_sketches_of_a_batch(data, model):
    batch, latents = begin(data, model, *FEW)._draw(0)
    for process in (0, 1):
        own, part = begin(data, model, *FEW, share=Share(process, 2))._draw(0)
        np.testing.assert_array_equal(own.windows, batch.windows[process::2])
        np.testing.assert_array_equal(own.points, batch.points[process::2])
        np.testing.assert_array_equal(part, latents[process::2])


def test_nobody_to_validate_with_is_refused(data, model):
    nobody = SimpleNamespace(**vars(data) | {"rows": lambda split: (data.identity < 2) & (split == "train")})
    with pytest.raises(InputError, match="validation"):
        begin(nobody, model)


def test_a_head_without_curves_is_refused(data, ball):
    from caricli.template.annotation import parse_annotation
    from caricli.template.template import Template

    vertices, faces = ball
    note = parse_annotation({"ibug68": list(range(68))}, len(vertices), "ball")
    plain: Any = SimpleNamespace(template=Template(vertices, faces, annotation=note))
    with pytest.raises(InputError, match="curves"):
        SketchTraining([data], plain, SketchConfig())
