import tracemalloc

import numpy as np

from caricli.geometry.lines.line_distances import line_distances


def test_distances_are_to_segments_and_ends():
    lines = [np.array([[0.0, 0], [10, 0]]), np.array([[20.0, 5]])]
    points = np.array([[5.0, 3], [-3, 4], [20, 6], [10, 0]])
    np.testing.assert_allclose(line_distances(points, lines), [3, 5, 1, 0])


def test_a_line_may_have_a_point_twice():
    assert line_distances(np.array([[1.0, 1]]), [np.array([[0.0, 0], [0, 0], [2, 0]])])[0] == 1


def test_a_long_line_is_looked_at_whole():
    turn = np.linspace(0, 2 * np.pi, 1001)
    circle = 10 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = np.array([[0.0, 0], [9, 0], [0, -12]])
    np.testing.assert_allclose(line_distances(points, [circle]), [10, 1, 2], atol=1e-3)


def test_many_points_take_little_memory():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(20_000, 2))
    line = rng.normal(size=(300, 2))
    tracemalloc.start()
    try:
        distances = line_distances(points, [line])
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(distances[[0, 7000, -1]], line_distances(points[[0, 7000, -1]], [line]))
    assert peak < 100e6
