import numpy as np

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
