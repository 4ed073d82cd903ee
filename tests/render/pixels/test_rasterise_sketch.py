import numpy as np
import pytest

from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.structures import Sketch, Stroke


def test_ink_lies_on_the_line():
    ink = rasterise_sketch(Sketch((Stroke(np.array([[10.0, 20], [50, 20]])),), (64, 64)), 64)
    assert ink.shape == (64, 64) and ink.dtype == np.uint8
    assert (ink[20, 12:49] > 200).all() and not ink[:18].any() and not ink[23:].any()


def test_a_line_between_pixels_is_shared_by_both():
    ink = rasterise_sketch(Sketch((Stroke(np.array([[10.0, 20.5], [50, 20.5]])),), (64, 64)), 64)
    assert abs(int(ink[20, 30]) - int(ink[21, 30])) < 20 and ink[20, 30] > 100


def test_the_canvas_is_centred_in_the_picture():
    # A line along the middle of a wide canvas stays in the middle.
    sketch = Sketch((Stroke(np.array([[0.0, 24.5], [99, 24.5]])),), (100, 50))
    ink = rasterise_sketch(sketch, 50)
    assert abs(int(ink[24, 25]) - int(ink[25, 25])) < 20 and ink[24, 25] > 100


def test_pressure_is_shade_and_width_is_width():
    line = np.array([[5.0, 20], [30, 20], [60, 20]])
    light = rasterise_sketch(Sketch((Stroke(line, pressure=np.array([0, 0, 1])),), (64, 64)), 64)
    assert light[20, 15] == 0 and 100 < light[20, 45] < 150
    wide = rasterise_sketch(Sketch((Stroke(line, width=6.0),), (64, 64)), 64)
    assert 5 <= (wide[:, 30] > 127).sum() <= 7


def test_dots_and_what_leaves_the_canvas():
    assert rasterise_sketch(Sketch((Stroke(np.array([[20.0, 20]])),), (64, 64)), 64)[20, 20] > 127
    far = rasterise_sketch(Sketch((Stroke(np.array([[-1e5, 20], [1e5, 20]])),), (64, 64)), 64)
    assert (far[20, 4:-4] > 200).all()
    assert not rasterise_sketch(Sketch(), 32).any()


def test_a_canvas_of_any_shape_and_size_fits_with_its_lines():
    """Of 200 x 100 pixels on 50: a quarter as large, its lines as well, from border to border."""
    line = np.array([[0.0, 20], [199, 20]])
    ink = rasterise_sketch(Sketch((Stroke(line, width=24.0), Stroke(line + [0, 60], width=24.0)), (200, 100)), 50)
    rows = np.flatnonzero(ink[:, 25] > 127)
    assert (ink[[17, 32]][:, [0, 49]] > 127).all()
    assert abs(rows.mean() - 24.5) < 0.5 and 10 <= len(rows) <= 14
    assert rows.min() == pytest.approx(17 - 3, abs=1.5) and rows.max() == pytest.approx(32 + 3, abs=1.5)


def test_the_dark_lies_over_the_light_whichever_was_drawn_first():
    dark = Stroke(np.array([[5.0, 30], [60, 30]]), width=3.0)
    light = Stroke(np.array([[30.0, 5], [30, 60]]), pressure=np.full(2, 0.25), width=3.0)
    for strokes in ((dark, light), (light, dark)):
        ink = rasterise_sketch(Sketch(strokes, (64, 64)), 64)
        assert ink[30, 30] == 255 and 40 < ink[15, 30] < 90
