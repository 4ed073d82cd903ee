from types import SimpleNamespace

import numpy as np
import pytest

from caricli.data.face_grid import face_grid
from caricli.errors import InputError


def stand_in(identity, level, expression):
    """Stands in for a Dataset."""
    return SimpleNamespace(identity=np.array(identity), level=np.array(level), expression=np.array(expression))


def test_rows_stand_where_people_and_expressions_say():
    data = stand_in([7, 7, 7, 7, 2, 2], [1, 2, 1, 2, 1, 1], [0, 0, 5, 5, 5, 0])
    grid = face_grid(data, np.arange(6))
    assert grid.people.tolist() == [[2, 1], [7, 1], [7, 2]] and grid.expressions.tolist() == [0, 5]
    assert grid.rows.tolist() == [[5, 4], [0, 2], [1, 3]]
    assert face_grid(data, np.array([1, 3])).rows.tolist() == [[1, 3]]


@pytest.mark.parametrize("expressions", [[0, 5, 0], [0, 0, 5]])
def test_a_table_that_is_not_full_is_refused(expressions):
    with pytest.raises(InputError, match="full grid"):
        face_grid(stand_in([1, 1, 2], [1, 1, 1], expressions), np.arange(3))


def test_people_of_several_levels_are_counted_once():
    data = stand_in([1, 1, 1, 1, 1, 2, 2], [1, 1, 2, 2, 2, 1, 1], [0, 5, 0, 5, 5, 0, 5])
    with pytest.raises(InputError, match="found 5 of 6 faces once, of 2 people at 3 levels in all$"):
        face_grid(data, np.arange(7))
