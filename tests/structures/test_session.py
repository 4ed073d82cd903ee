import math

import pytest

from caricli.errors import InputError
from caricli.limits import MAX_OPERATIONS
from caricli.structures import Operation, Session, Start

DIGITS = "0f" * 32


def test_numbers_are_rounded_before_anything_is_done_with_them():
    parameters = {"a": 0.123456789, "b": [1, -1e-9, [2.00000049]], "c": {"d": True, "e": None, "f": "0.123456789"}}
    rounded = Operation("draw", parameters).parameters
    assert rounded == {"a": 0.123457, "b": [1, 0.0, [2.0]], "c": {"d": True, "e": None, "f": "0.123456789"}}
    assert math.copysign(1, rounded["b"][1]) == 1 and rounded["c"]["d"] is True
    assert Operation("draw", rounded).parameters == rounded


@pytest.mark.parametrize("parameters", [{"a": math.nan}, {"a": [math.inf]}, {"a": {1: 2}}, {"a": object()}, [1]])
def test_values_that_json_has_not_are_refused(parameters):
    with pytest.raises(InputError, match="parameters: expected"):
        Operation("draw", parameters)


@pytest.mark.parametrize("name", ["", "Draw", "a b", "1", "a" * 41, 3, "../x"])
def test_other_names_are_refused(name):
    with pytest.raises(InputError, match="name: expected small letters"):
        Operation(name)


@pytest.mark.parametrize("file", ["", "../face.npz", "/face.npz", "a\\b", "..", ".", "a\nb", "x" * 256, None])
def test_a_start_is_a_file_beside_the_session(file):
    with pytest.raises(InputError, match="file: expected the name of a file without a folder"):
        Start(file, DIGITS)


def test_a_start_has_a_hash_and_a_session_an_end():
    assert Start("face.npz", DIGITS).sha256 == DIGITS
    with pytest.raises(InputError, match="sha256: expected 64"):
        Start("face.npz", "0F" * 32)
    with pytest.raises(InputError, match="operations: expected at most"):
        Session(None, (Operation("clear"),) * (MAX_OPERATIONS + 1))
