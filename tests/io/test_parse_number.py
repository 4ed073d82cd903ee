import numpy as np
import pytest

from caricli.io.parse_number import parse_number, parse_numbers, parse_whole

NONE = [
    "1_0",
    " 1",
    "1 ",
    "1\n",
    "\u0661",
    "\uff11",
    "nan",
    "inf",
    "-Infinity",
    "0x10",
    "1e999",
    "",
    "e",
    "1e",
    "1,5",
    "\udcff",
]


@pytest.mark.parametrize("text", NONE)
def test_what_python_takes_besides_is_refused(text):
    data = text.encode("utf-8", "replace")
    for parse in (parse_number, parse_whole):
        for form in (text, data):
            with pytest.raises(ValueError):
                parse(form)
    with pytest.raises(ValueError):
        parse_numbers([b"1", data])


def test_numbers():
    for text, value in {"1": 1, "-0.5": -0.5, ".5": 0.5, "5.": 5, "+1e-3": 1e-3, "1E2": 100, "007": 7}.items():
        assert parse_number(text) == parse_number(text.encode()) == value
        assert parse_numbers([text.encode()] * 2).tolist() == [value, value]
    assert parse_numbers([]).shape == (0,)
    assert parse_numbers([b"1"]).dtype == np.float64


def test_whole_numbers():
    assert [parse_whole(text) for text in ("0", "-7", "+12", b"9" * 18)] == [0, -7, 12, 10**18 - 1]
    for text in ("1.0", "1e2", "010", "9" * 19, "--1"):
        with pytest.raises(ValueError):
            parse_whole(text)
