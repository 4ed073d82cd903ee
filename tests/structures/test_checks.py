import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures.checks import are_apart, number_problem, padding_is_last, refuse, repeats, shape_problem


def test_the_first_problem_is_raised():
    refuse(None, None)
    with pytest.raises(InputError, match="^b: expected$"):
        refuse(None, "b: expected", "c: expected")


def test_shapes_with_any_length_but_none():
    assert shape_problem("x", np.zeros((5, 2)), (None, 2)) is None
    assert shape_problem("x", np.zeros(()), ()) is None
    assert "(*,2), found (0, 2)" in shape_problem("x", np.zeros((0, 2)), (None, 2))
    assert "expected finite numbers" in shape_problem("x", np.full(2, 1e39), (2,))


def test_repeats_and_padding():
    polygons = np.array([[0, 1, 2, -1, -1], [0, 1, 2, 0, -1], [3, 1, 2, 0, 3]])
    assert repeats(polygons).tolist() == [False, True, True]
    assert padding_is_last(polygons)
    assert not padding_is_last(np.array([[0, 1, -1, 2]])) and not padding_is_last(np.array([[0, 1, 2, -2]]))


@pytest.mark.parametrize(
    "value", [np.nan, np.inf, -np.inf, 1.1e9, -1.1e9, np.int64(-(2**63)), np.uint64(2**64 - 1), "1", None]
)
def test_what_is_no_number_or_too_large(value):
    assert "x: expected finite numbers of at most 1e+09" in number_problem("x", np.array([0, value]))


@pytest.mark.filterwarnings("error")
def test_numbers_up_to_the_cap():
    half = np.array([6e4, -6e4], np.float16)
    for values in (half, np.array([1e9, -1e9]), np.array([True]), np.zeros((0, 3)), np.array(7, np.uint8)):
        assert number_problem("x", values) is None
    assert "finite metres of at most 2" in number_problem("x", np.array([3.0]), 2, "metres")
    assert "of at most 1e+09" in number_problem("x", np.array([np.inf], np.float16))


def test_points_that_are_apart():
    assert are_apart(np.array([[0, 0], [1e-3, 0]])) and are_apart(np.array([[1e6, 0], [1e6 + 2, 0]]))
    assert not are_apart(np.zeros((4, 2))) and not are_apart(np.full((4, 3), 1e5)) and not are_apart(1e-300 * np.eye(3))
