import json

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.bilinear.space import BilinearSpace
from caricli.models.sketch.config import PUBLISHED, PublishedSize
from caricli.models.sketch.model import SketchModel, sketch_from_checkpoint, sketch_to_checkpoint
from caricli.models.sketch.networks import CAMERA
from caricli.models.sketch.published import PublishedNetwork, shown_points
from caricli.models.sketch.window import POINTS
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from tests.models.test_sketch import told_of

CURVES = ("brow", "nose", "fold")
LINE = np.stack([np.linspace(40, 90, 9), 30 + 10 * np.sin(np.linspace(0, 3, 9))], 1)


def network(variant, local=False):
    size = PublishedSize(variant, (4, 6, 6, 6, 6), 12, 10, 8, local, 4, 3)
    own = PublishedNetwork(size, len(CURVES), POINTS, 64, torch.Generator().manual_seed(0))
    generator = torch.Generator().manual_seed(1)
    for layer in own.last:
        assert isinstance(layer, torch.nn.Linear)
        torch.nn.init.normal_(layer.weight, std=0.3, generator=generator)
    return own


@pytest.fixture(scope="module")
def drawn():
    """Points (P, E, K, POINTS, 2) of people with expressions, bilinear in both."""
    generator = np.random.default_rng(0)
    core = 0.1 * generator.normal(size=(len(CURVES) * POINTS * 2, 4, 3))
    people = np.concatenate([np.ones((9, 1)), generator.normal(size=(9, 3))], 1)
    expressions = np.concatenate([np.ones((5, 1)), generator.normal(size=(5, 2))], 1)
    return np.einsum("mij,pi,ej->pem", core, people, expressions).reshape(9, 5, len(CURVES), POINTS, 2)


@pytest.fixture(scope="module")
def told(drawn):
    """A network that has learnt the points."""
    own = network("pixel_shape")
    own.learn_points(BilinearSpace.train(shown_points(drawn.reshape(45, *drawn.shape[2:])).reshape(9, 5, -1), 4, 3))
    return own


@pytest.mark.parametrize("variant", PUBLISHED)
@pytest.mark.parametrize("local", [False, True])
def test_variants_look_at_what_they_are_named_for(variant, local):
    own = network(variant, local).eval()
    about = PUBLISHED[variant]
    windows = torch.rand(2, 1, 64, 64, generator=torch.Generator().manual_seed(2))
    coefficients = torch.randn(2, own.dimension, generator=torch.Generator().manual_seed(3))
    with torch.no_grad():
        first = own.tell(windows, coefficients)
        assert first.shape == (2, 6 + CAMERA)
        assert about.pixels == bool((own.tell(1 - windows, coefficients) - first).abs().max() > 1e-4)
        assert about.points == bool((own.tell(windows, -coefficients) - first).abs().max() > 1e-4)
        ends = own.hidden(windows, coefficients)
    assert about.branches != torch.equal(*ends)


def test_coefficients_are_those_of_the_points(told, drawn):
    """Decoded they are the points again, and where half of them are missing nearly so."""
    points = drawn[:, 0].astype(np.float32)
    codes = told.coefficients(points)
    space = told._told_space()
    found = space.decode(space.prior.colour(codes.astype(float)))
    assert np.abs(found - shown_points(points)).max() < 0.05 * np.abs(points).max()
    part = points.copy()
    part[:, 0] = np.nan
    fewer = space.decode(space.prior.colour(told.coefficients(part).astype(float)))
    assert np.abs(fewer - shown_points(points)).mean() < 0.3 * np.abs(points - points.mean(0)).mean()


def test_nothing_known_is_what_is_usual(told):
    np.testing.assert_allclose(told.coefficients(np.full((2, 3, POINTS, 2), np.nan)), 0, atol=1e-6)


def test_a_checkpoint_rebuilds_it_and_its_points(told, drawn):
    model = SketchModel(told, 64, CURVES, "a" * 64, {"config": {"held": 0.1, "seed": 3}})
    tensors, about = sketch_to_checkpoint(model)
    again = sketch_from_checkpoint(tensors, json.loads(json.dumps(about)), "it")
    assert (again.label, again.on_canvas, again.wrinkled, again.held_out) == ("PixelShapeCNN", True, True, (0.1, 3))
    windows = np.random.default_rng(0).integers(0, 256, (9, 64, 64), np.uint8)
    points = drawn[:, 1].astype(np.float32)
    np.testing.assert_allclose(again.read(windows, points), model.read(windows, points), atol=0.02)
    assert again.model_id == model.model_id


def test_a_sketch_elsewhere_on_a_larger_canvas_is_the_same_face(told):
    model = SketchModel(told, 64, CURVES, "a" * 64)
    sketch = Sketch((Stroke(LINE, StrokeKind.FEATURE, "brow"), Stroke(LINE + 60)), (200, 160))
    moved = Sketch(tuple(s.moved(3 * s.points + [70, 20]) for s in sketch.strokes), (700, 600))
    latent, camera = told_of(model, sketch)
    again, other = told_of(model, moved)
    np.testing.assert_allclose(again, latent, atol=1e-5)
    assert other.scale == pytest.approx(3 * camera.scale, rel=1e-4)
    wrinkled = sketch.with_strokes([*sketch.strokes, Stroke(LINE + 20, StrokeKind.WRINKLE)])
    assert np.abs(told_of(model, wrinkled)[0] - latent).max() > 1e-4


@pytest.mark.parametrize(
    "change",
    [
        {"variant": "oval"},
        {"variant": 3},
        {"widths": [4, 6]},
        {"local": 1},
        {"identity": 5},
        {"told": 0},
        {"widths": [4, 6, 6, 6, 9999]},
    ],
)
def test_what_does_not_fit_is_refused(told, change):
    tensors, about = sketch_to_checkpoint(SketchModel(told, 64, CURVES, "a" * 64))
    about = json.loads(json.dumps(about))
    with pytest.raises(InputError, match="^it: "):
        sketch_from_checkpoint(tensors, about | {"network": about["network"] | change}, "it")
