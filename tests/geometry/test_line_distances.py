import numpy as np

from caricli.geometry.line_distances import line_distances


def test_distances_are_to_segments_and_ends():
    lines = [np.array([[0.0, 0], [10, 0]]), np.array([[20.0, 5]])]
    points = np.array([[5.0, 3], [-3, 4], [20, 6], [10, 0]])
    np.testing.assert_allclose(line_distances(points, lines), [3, 5, 1, 0])


def test_a_line_may_have_a_point_twice():
    assert line_distances(np.array([[1.0, 1]]), [np.array([[0.0, 0], [0, 0], [2, 0]])])[0] == 1
