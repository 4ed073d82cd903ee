import numpy as np

from caricli.geometry.lines.cut_line import cut_line


def test_pieces_begin_where_those_before_end():
    line = np.array([[0.0, 0], [4, 0], [4, 4]])
    first, second, third = cut_line(line, [0.25, 0.75])
    np.testing.assert_allclose(first, [[0, 0], [2, 0]])
    np.testing.assert_allclose(second, [[2, 0], [4, 0], [4, 2]])
    np.testing.assert_allclose(third, [[4, 2], [4, 4]])


def test_a_cut_at_a_point_doubles_none():
    line = np.array([[0.0, 0], [4, 0], [4, 4]])
    first, second = cut_line(line, [0.5])
    np.testing.assert_allclose(first, line[:2])
    np.testing.assert_allclose(second, line[1:])


def test_no_cut_leaves_the_line():
    line = np.array([[0.0, 0], [4, 0], [4, 4]])
    (whole,) = cut_line(line, [])
    np.testing.assert_array_equal(whole, line)


def test_what_is_carried_is_cut_along():
    line = np.array([[0.0, 0], [4, 0], [4, 4]])
    first, second = cut_line(line, [0.25], np.array([0.0, 1.0, 0.5]))
    np.testing.assert_allclose(first, [[0.0, 0, 0], [2.0, 0, 0.5]])
    np.testing.assert_allclose(second, [[2.0, 0, 0.5], [4.0, 0, 1], [4.0, 4, 0.5]])
    _, several = cut_line(line, [0.25], np.array([[0.0, 3], [1.0, 3], [0.5, 3]]))
    np.testing.assert_allclose(several, np.column_stack([second, [3, 3, 3]]))
