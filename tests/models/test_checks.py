import numpy as np
import pytest

from caricli.errors import InputError
from caricli.models.checks import check_schema, fitting_weights, named_weights, whole_number


@pytest.mark.parametrize("value", [2, 5, 9])
def test_whole_numbers_within_their_limits_are_taken(value):
    assert whole_number(value, (2, 9), "stride") == value


@pytest.mark.parametrize("value", [1, 10, True, 3.0, "3", None, [3], np.nan])
def test_everything_else_is_no_whole_number(value):
    with pytest.raises(InputError, match="expected a stride from 1 to 8|expected a stride from 2 to 9"):
        whole_number(value, (1, 8) if value is True else (2, 9), "stride")


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_weights_of_any_precision_are_taken(kind):
    found = fitting_weights("w", np.full((2, 3), 0.5, kind), (2, 3))
    assert found.dtype == np.float32 and (found == 0.5).all()


@pytest.mark.parametrize(
    "array",
    [np.zeros((3, 2), np.float32), np.zeros((2, 3), np.int32), np.zeros((2, 3), bool), np.full((2, 3), np.nan)],
    ids=["shape", "whole numbers", "yes and no", "no number"],
)
def test_weights_of_another_shape_or_kind_are_refused(array):
    with pytest.raises(InputError, match="w"):
        named_weights({"w": array}, "w", (2, 3))


def test_what_is_not_there_and_another_schema_are_refused():
    with pytest.raises(InputError, match="found others \\(w\\)"):
        named_weights({}, "w", (2, 3))
    check_schema({"schema": "a/1"}, "a/1", "thing")
    with pytest.raises(InputError, match="expected a thing of schema 'a/1', found 'a/2'"):
        check_schema({"schema": "a/2"}, "a/1", "thing")
