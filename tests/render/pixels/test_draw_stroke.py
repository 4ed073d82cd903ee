import numpy as np
import pytest

from caricli.render.pixels.draw_stroke import draw_stroke


def test_the_longer_side_fills_the_picture_and_the_shape_stays():
    line = draw_stroke(np.array([[0.0, 0], [100, 50]]), 64)
    rows, columns = np.nonzero(line)
    assert np.ptp(columns) > 52 and 24 < np.ptp(rows) < 36
    assert abs(rows.mean() - 31.5) < 1 and abs(columns.mean() - 31.5) < 1


def test_place_size_and_direction_do_not_matter():
    stroke = np.array([[0.0, 0], [30, 10], [20, 40]])
    first = draw_stroke(stroke, 32).astype(int)
    assert np.abs(draw_stroke(stroke[::-1] * 3 + [7, -9], 32) - first).max() <= 8
    assert np.abs(draw_stroke(stroke * [-1, 1], 32)[:, ::-1] - first).mean() < 4


@pytest.mark.parametrize("size", [8, 16, 33])
def test_small_pictures_have_lines_too(size):
    ink = draw_stroke(np.array([[0.0, 0], [10, 10]]), size)
    assert ink.shape == (size, size) and (np.diag(ink)[size // 4 : -size // 4] > 100).all()


def test_a_sixteenth_stays_free_on_every_side_but_for_the_pen():
    ink = draw_stroke(np.array([[0.0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]), 128)
    rows, columns = np.nonzero(ink > 100)
    for places in (rows, columns):
        assert abs(places.min() - 8) <= 4 and abs(places.max() - 119) <= 4
