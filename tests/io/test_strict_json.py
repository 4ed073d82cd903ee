import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from caricli.errors import InputError, OutputError
from caricli.io import strict_json
from caricli.io.strict_json import read_json, write_json

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**30), 10**30)
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(value=VALUES)
def test_round_trip(tmp_path_factory, value):
    path = tmp_path_factory.mktemp("json") / "a.json"
    write_json(path, value)
    back = read_json(path)
    assert back == value and repr(back) == repr(value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'{"a": NaN}', "found NaN, which is not a number"),
        (b"[Infinity]", "found Infinity"),
        (b"[-Infinity]", "found -Infinity"),
        (b"[1e999]", "the number 1e999, which is too large"),
        (b"[" + b"9" * 5000 + b"]", "which is too large"),
        (b'{"a": 1, "b": {"c": 1, "c": 2}}', "the key 'c' twice"),
        (b"[" * 65 + b"]" * 65, "nested at most 64 deep, found 65"),
        (b'{"a":' * 100_000 + b"1" + b"}" * 100_000, "nested at most 64 deep, found 100000"),
        (b"[" * 100_000, "nested at most 64 deep"),
        (b'{"a": "\xff"}', "in UTF-8, found an invalid byte at 7"),
        (b'"\xed\xa0\x80"', "in UTF-8"),
        (b'["\\ud800"]', "half of a surrogate pair"),
        (b'{"a": 1,}', "expected strict JSON"),
        (b'{"a": 1} x', "Extra data"),
        (b"'a'", "expected strict JSON"),
        (b'["a\nb"]', "Invalid control character"),
        (b"\xef\xbb\xbf\xef\xbb\xbf{}", "BOM"),
        (b"\xff\xfe{\0}\0", "binary data"),
        (b"<!DOCTYPE html><html></html>", "an HTML or XML page"),
        (b"   ", "expected strict JSON"),
        (b'"' + b'\\"' * 1000, "expected strict JSON"),
    ],
)
def test_malformed(tmp_path, data, message):
    path = tmp_path / "a.json"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message) as caught:
        read_json(path)
    assert "a.json" in str(caught.value) and "\n" not in str(caught.value)


def test_a_byte_order_mark_is_passed_over(tmp_path):
    (tmp_path / "a.json").write_bytes(b"\xef\xbb\xbf" + b'{"a": 1}\r\n')
    assert read_json(tmp_path / "a.json") == {"a": 1}


def test_brackets_in_texts_do_not_count(tmp_path):
    value = [["[" * 1000 + '\\"[{', {"{" * 1000: 1}]]
    (tmp_path / "a.json").write_text(json.dumps(value))
    assert read_json(tmp_path / "a.json") == value
    nested = json.loads("[" * 64 + "]" * 64)
    (tmp_path / "a.json").write_text(json.dumps(nested))
    assert read_json(tmp_path / "a.json") == nested


def test_a_large_file_is_refused_unread(tmp_path, monkeypatch):
    (tmp_path / "a.json").write_text("[1, 2, 3]")
    monkeypatch.setattr(strict_json, "MAX_JSON_BYTES", 5)
    with pytest.raises(InputError, match="at most 5 bytes, found 9"):
        read_json(tmp_path / "a.json")


def test_layout_and_conversions(tmp_path):
    value = {"b": np.float32(0.5), "a": np.arange(2), "c": (True, np.bool_(False), Path("x")), "é": np.int64(3)}
    write_json(tmp_path / "a.json", value)
    expected = (
        '{\n  "b": 0.5,\n  "a": [\n    0,\n    1\n  ],\n  "c": [\n    true,\n    false,\n    "x"\n  ],\n  "é": 3\n}\n'
    )
    assert (tmp_path / "a.json").read_text(encoding="utf-8") == expected


@pytest.mark.parametrize("value", [float("nan"), [np.inf], {"a": np.array([np.nan])}, "\ud800"])
def test_what_could_not_be_read_back_is_not_written(tmp_path, value):
    with pytest.raises(OutputError, match="a.json: expected finite numbers and UTF-8 text"):
        write_json(tmp_path / "a.json", value)
    assert not (tmp_path / "a.json").exists()
    with pytest.raises(TypeError, match="object has no JSON form"):
        write_json(tmp_path / "a.json", [object()])
