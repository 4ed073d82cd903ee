import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures.checks import padding_is_last, refuse, repeats, shape_problem


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
