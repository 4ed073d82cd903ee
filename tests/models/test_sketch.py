import json
from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import (
    SketchModel,
    sketch_from_checkpoint,
    sketch_to_checkpoint,
    window_camera,
    window_picture,
)
from caricli.models.sketch.networks import CAMERA, SketchNetwork
from caricli.models.sketch.window import POINTS, Window, curve_points
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

SMALL = SketchSize(8, (8, 12, 16), (0, 1, 1), 16, 24, 6)
CURVES = ("brow", "nose", "fold")
LINE = np.stack([np.linspace(40, 90, 9), 30 + 10 * np.sin(np.linspace(0, 3, 9))], 1)


def lines(count):
    """(count, K, P, 2) curves that differ in four ways, all seen from a distance of its own, and drawn unsteadily."""
    generator = np.random.default_rng(5)
    ways = np.random.default_rng(6).normal(size=(4, len(CURVES), POINTS, 2))
    along = np.linspace(-0.5, 0.5, POINTS)[:, None] * [1, 0.3] + np.array([[[0, 0.4]], [[0, 0]], [[0, -0.4]]])
    bent = along + 0.05 * np.tensordot(generator.normal(size=(count, 4)), ways, 1)
    return bent + 0.002 * generator.normal(size=bent.shape)


@pytest.fixture(scope="module")
def model():
    generator = torch.Generator().manual_seed(0)
    network = SketchNetwork(SMALL, len(CURVES), POINTS, 5, generator)
    for layer in (network.last, network.plain, network.more):
        torch.nn.init.normal_(layer.weight, std=0.1, generator=generator)
    network.lines.learn(lines(40), np.ones((40, len(CURVES)), bool))
    # A brow runs to the right, a nose down.
    network.usual[0, :, 0] = torch.linspace(-0.5, 0.5, POINTS)
    network.usual[1, :, 1] = torch.linspace(-0.5, 0.5, POINTS)
    return SketchModel(network, 64, CURVES, "a" * 64, {"seed": 0})


@pytest.fixture(scope="module")
def sketch():
    brow = Stroke(LINE, StrokeKind.FEATURE, "brow")
    return Sketch((brow, Stroke(LINE[:, ::-1] + [0, 5]), Stroke(LINE + 60)), (200, 160))


def told_of(model, sketch):
    """What a network makes of a sketch: latent and camera."""
    ink, points, window = model.look(sketch)
    numbers = model.read(ink[None], points[None])[0]
    return numbers[:-CAMERA], window_camera(numbers[-CAMERA:], window)


def test_a_curve_is_read_in_the_direction_in_which_it_usually_runs(model):
    usual = model.network.usual.double().numpy()
    window = Window(np.array([65.0, 30.0]), 30.0)
    ways = [curve_points([Stroke(line, curve="brow")], window, CURVES, usual) for line in (LINE, LINE[::-1])]
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-12)
    assert ways[0][0, 0, 0] < ways[0][0, -1, 0] and np.isnan(ways[0][1:]).all()


def test_of_several_strokes_of_a_curve_the_longest_counts(model):
    usual = model.network.usual.double().numpy()
    window = Window(np.array([65.0, 30.0]), 30.0)
    strokes = [Stroke(LINE[:3], curve="brow"), Stroke(LINE, curve="brow"), Stroke(LINE[3:5], curve="brow")]
    alone = curve_points(strokes[1:2], window, CURVES, usual)
    np.testing.assert_array_equal(curve_points(strokes, window, CURVES, usual), alone)


def test_a_sketch_elsewhere_on_a_larger_canvas_is_the_same_face(model, sketch):
    moved = Sketch(tuple(stroke.moved(3 * stroke.points + [70, 20]) for stroke in sketch.strokes), (700, 600))
    latent, camera = told_of(model, sketch)
    again, other = told_of(model, moved)
    np.testing.assert_allclose(again, latent, atol=1e-5)
    np.testing.assert_allclose(other.rotation, camera.rotation, atol=1e-5)
    assert other.scale == pytest.approx(3 * camera.scale, rel=1e-4)
    np.testing.assert_allclose(other.translation, 3 * camera.translation + [70, 20], atol=1e-2)


def test_names_count_and_further_wrinkles_do_not(model, sketch):
    latent, _ = told_of(model, sketch)
    nameless = Sketch(tuple(Stroke(stroke.points) for stroke in sketch.strokes), sketch.size)
    assert np.abs(told_of(model, nameless)[0] - latent).max() > 1e-3
    creased = sketch.with_strokes([*sketch.strokes, Stroke(LINE + 20, StrokeKind.WRINKLE)])
    np.testing.assert_array_equal(told_of(model, creased)[0], latent)
    folded = sketch.with_strokes([*sketch.strokes, Stroke(LINE + 20, StrokeKind.WRINKLE, "fold")])
    assert np.abs(told_of(model, folded)[0] - latent).max() > 1e-3


@pytest.mark.parametrize("strokes", [(), (Stroke(LINE[:1]),), (Stroke(LINE, StrokeKind.WRINKLE),)])
def test_a_sketch_without_lines_is_refused(model, strokes):
    with pytest.raises(InputError, match="expected a sketch with lines"):
        told_of(model, Sketch(strokes))


def test_what_comes_out_is_in_the_units_of_start_and_step(model):
    windows = np.random.default_rng(0).integers(0, 256, (2, 64, 64), np.uint8)
    points = np.full((2, 3, POINTS, 2), np.nan)
    before = model.read(windows, points)
    assert before.shape == (2, 5 + CAMERA)
    model.network.start.fill_(3.0)
    model.network.step.fill_(2.0)
    np.testing.assert_allclose(model.read(windows, points), 3 + 2 * before, rtol=1e-4, atol=1e-4)
    model.network.start.fill_(0.0)
    model.network.step.fill_(1.0)


def test_a_checkpoint_rebuilds_it(model, sketch):
    tensors, about = sketch_to_checkpoint(model)
    again = sketch_from_checkpoint(tensors, json.loads(json.dumps(about)), "it")
    assert (again.size, again.basis, again.recipe, again.curves) == (64, "a" * 64, {"seed": 0}, CURVES)
    np.testing.assert_allclose(told_of(again, sketch)[0], told_of(model, sketch)[0], atol=0.02)
    assert again.model_id == model.model_id


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "caricli.model/1"},
        {"size": 63.5},
        {"size": 100},
        {"dimension": 0},
        {"curves": []},
        {"curves": ["nose", 3]},
        {"basis": None},
        {"network": {}},
        {"network": {"stem": 8, "widths": [8, 12], "blocks": [0, 1, 1], "told": 16, "hidden": 24, "components": 6}},
        {"curves": ["nose"]},
    ],
)
def test_what_does_not_fit_is_refused(model, change):
    tensors, about = sketch_to_checkpoint(model)
    with pytest.raises(InputError, match="^it: "):
        sketch_from_checkpoint(tensors, json.loads(json.dumps(about)) | change, "it")


def test_points_in_the_mirror_are_those_of_the_curves_of_the_other_side():
    """They run as those do, whichever way the lines were drawn."""
    curves = ("eye_left", "nose", "eye_right", "ear_left")
    network = SketchNetwork(SMALL, len(curves), POINTS, 5, torch.Generator().manual_seed(0))
    along = np.linspace(-0.1, 0.1, POINTS)
    usual = np.zeros((4, POINTS, 2))
    # Both eyes run from their inner corner outwards, the nose down; an ear has no partner.
    usual[0] = np.stack([0.4 + along, 0 * along], 1)
    usual[1] = np.stack([0 * along, along], 1)
    usual[2] = np.stack([-0.4 - along, 0 * along], 1)
    usual[3] = np.stack([0.9 + 0 * along, along], 1)
    network.usual[:] = torch.from_numpy(usual)
    model = SketchModel(network, 64, curves, "a" * 64)
    drawn = usual + np.random.default_rng(0).normal(0, 0.01, usual.shape)
    found = model.mirrored(drawn[None])[0]
    np.testing.assert_allclose(found[0], drawn[2] * [-1, 1])
    np.testing.assert_allclose(found[1], drawn[1] * [-1, 1])
    np.testing.assert_allclose(found[2], drawn[0] * [-1, 1])
    assert np.isnan(found[3]).all()
    # Where the usual ways of both sides differ, the mirror image is turned around.
    network.usual[2] = torch.from_numpy(usual[2, ::-1].copy())
    found = SketchModel(network, 64, curves, "a" * 64).mirrored(drawn[None])[0]
    np.testing.assert_allclose(found[0], drawn[2, ::-1] * [-1, 1])
    np.testing.assert_allclose(found[2], drawn[0, ::-1] * [-1, 1])


def test_strokes_fill_the_window_as_far_as_they_are_to(sketch):
    window = Window.around([stroke.points for stroke in sketch.strokes], 200)
    inside = np.concatenate([window.inside(stroke.points) for stroke in sketch.strokes])
    assert np.abs(inside).max() == pytest.approx(0.86)
    np.testing.assert_allclose(inside.min(0) + inside.max(0), 0, atol=1e-9)
    ink = window_picture(sketch, window, 64)
    rows, columns = np.nonzero(ink > 100)
    middles = [(values.min() + values.max()) / 2 for values in (rows, columns)]
    np.testing.assert_allclose(middles, 31.5, atol=0.51)
    assert max(np.ptp(rows), np.ptp(columns)) == pytest.approx(0.86 * 63, abs=2.1)


def test_what_is_seen_does_not_hang_on_the_size_of_the_canvas(sketch):
    drawn = sketch.with_strokes([replace(stroke, width=0.01 * max(sketch.size)) for stroke in sketch.strokes])
    pictures = []
    for side in (256, 4096):
        scaled = drawn.scaled((side, side))
        window = Window.around([stroke.points for stroke in scaled.strokes], max(scaled.size))
        pictures.append(window_picture(scaled, window, 128).astype(int))
    assert pictures[0].any() and np.abs(pictures[0] - pictures[1]).mean() < 0.5
    thick = drawn.with_strokes([replace(stroke, width=0.2 * max(sketch.size)) for stroke in sketch.strokes])
    assert (window_picture(thick, Window.around([s.points for s in thick.strokes], 200), 128) > 0).mean() < 0.1
