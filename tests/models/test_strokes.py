import json

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.sketch.window import Window
from caricli.models.strokes.config import StrokeSize
from caricli.models.strokes.model import StrokeModel, strokes_from_checkpoint, strokes_to_checkpoint
from caricli.models.strokes.networks import StrokeNetwork
from caricli.models.strokes.places import STEP, Places, line_picture
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

CURVES = ("brow_left", "brow_right", "nose")
SIZE = StrokeSize((8, 8, 8, 8), (0, 0, 0, 0), 5, 8)
LINES = [
    np.array([[40.0, 60], [90, 50], [120, 70]]),
    np.array([[160.0, 70], [220, 60]]),
    np.array([[128.0, 100], [130, 160]]),
]
SKETCH = Sketch(tuple(map(Stroke, LINES)))


@pytest.fixture(scope="module")
def model():
    generator = torch.Generator().manual_seed(0)
    network = StrokeNetwork(SIZE, 4, generator)
    torch.nn.init.normal_(network.last.weight, generator=generator)
    return StrokeModel(network, 64, CURVES, {"seed": 0})


def test_places_lie_on_their_lines_at_equal_distances():
    window = Window.around(LINES, 256)
    places = Places.of(LINES, window)
    for number, line in enumerate(LINES):
        own = places.about[places.owner == number]
        length = np.linalg.norm(np.diff(window.inside(line), axis=0), axis=1).sum()
        assert len(own) == round(length / STEP)
        np.testing.assert_allclose(places.along[places.owner == number], (np.arange(len(own)) + 0.5) / len(own))
    straight = places.about[places.owner == 2]
    np.testing.assert_allclose(np.linalg.norm(np.diff(straight[:, :2], axis=0), axis=1), STEP, rtol=0.05)
    angle = 2 * np.arctan2(60, 2)
    np.testing.assert_allclose(straight[:, 2:], [[np.cos(angle), np.sin(angle)]] * len(straight), atol=1e-5)


def test_a_line_and_the_same_backwards_have_the_same_directions():
    window = Window.around(LINES, 256)
    there, back = (Places.of([line], window).about for line in (LINES[0], LINES[0][::-1]))
    np.testing.assert_allclose(there, back[::-1], atol=1e-6)


def test_a_dot_has_a_place_and_long_scribbles_have_not_too_many():
    window = Window.around(LINES, 256)
    assert len(Places.of([np.array([[50.0, 50]])], window).about) == 1
    scribble = np.random.default_rng(0).uniform(0, 256, (5000, 2))
    assert len(Places.of([scribble], window).about) <= 8001
    assert Places.of([], window).about.shape == (0, 4)


def test_ink_is_where_lines_are():
    window = Window.around(LINES, 256)
    ink = line_picture(LINES, window, 64)
    about = Places.of(LINES, window).about
    columns, rows = np.rint(31.5 * (1 + about[:, :2])).astype(int).T
    assert ink.shape == (64, 64) and (ink[rows, columns] > 0).mean() > 0.95


def test_chances_of_places(model):
    reading = model.read(SKETCH)
    assert reading.chances.shape == (len(reading.places.owner), 3) and reading.curves == CURVES
    assert (reading.chances > 0).all() and (reading.chances.sum(1) < 1).all()


def test_where_and_how_large_a_sketch_is_does_not_matter(model):
    moved = Sketch(tuple(Stroke(3 * line + [40, 10]) for line in LINES), (900, 700))
    np.testing.assert_allclose(model.read(moved).chances, model.read(SKETCH).chances, atol=0.02)


def test_the_mirror_image_is_read_the_same(model):
    turned = Sketch(tuple(Stroke(line * [-1, 1] + [255, 0]) for line in LINES))
    np.testing.assert_allclose(model.read(turned).chances[:, [1, 0, 2]], model.read(SKETCH).chances, atol=0.01)


def test_widths_names_and_pressure_are_not_looked_at(model):
    named = Sketch(tuple(Stroke(line, StrokeKind.FEATURE, "nose", np.full(len(line), 0.4), 7.0) for line in LINES))
    np.testing.assert_array_equal(model.read(named).chances, model.read(SKETCH).chances)


def test_an_empty_sketch_is_refused(model):
    with pytest.raises(InputError, match="expected a sketch with lines"):
        model.read(Sketch(()))


def test_weights_that_overflow_are_refused():
    network = StrokeNetwork(SIZE, 4, torch.Generator().manual_seed(0))
    with torch.no_grad():
        for weights in network.parameters():
            weights.fill_(6e4)
    with pytest.raises(InputError, match="overflow"):
        StrokeModel(network, 64, CURVES).read(SKETCH)


def test_a_patch_is_the_ink_around_a_place():
    network = StrokeNetwork(SIZE, 2, torch.Generator().manual_seed(0))
    assert network.size.patch == 5
    from caricli.models.strokes.networks import _patches

    windows = torch.zeros(1, 1, 64, 64)
    windows[0, 0, 20, 30] = 1
    places = torch.tensor([[[30 / 31.5 - 1, 20 / 31.5 - 1, 1, 0], [-1, -1, 1, 0.0]]])
    patches = _patches(windows, places, 5).reshape(2, 5, 5)
    assert patches[0, 2, 2] == 1 and patches[0].sum() == 1 and patches[1].sum() == 0


def test_a_checkpoint_rebuilds_it(model):
    tensors, metadata = strokes_to_checkpoint(model)
    again = strokes_from_checkpoint(tensors, json.loads(json.dumps(metadata)), "here")
    assert again.model_id == model.model_id and again.recipe == {"seed": 0}
    np.testing.assert_allclose(again.read(SKETCH).chances, model.read(SKETCH).chances, atol=0.01)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": "caricli.gesture/1"}, "stroke network"),
        ({"size": 80}, "multiple of 32"),
        ({"curves": ["nose"]}, "last.weight: expected"),
        ({"curves": [3]}, "names of curves"),
        ({"curves": ["nose", "nose", "brow_left"]}, "every curve once"),
        ({"network": {"widths": [8]}}, "expected a network of"),
        (
            {"network": {"widths": [4096] * 4, "blocks": [9] * 4, "patch": 5, "told": 8}},
            "expected the weights of such a network",
        ),
    ],
)
def test_another_file_is_refused(model, change, message):
    tensors, metadata = strokes_to_checkpoint(model)
    with pytest.raises(InputError, match=message):
        strokes_from_checkpoint(tensors, json.loads(json.dumps(metadata)) | change, "here")
