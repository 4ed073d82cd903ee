"""JSON read strictly and written reproducibly."""

import json
import math
import os
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.files import decode_text, read_bytes
from caricli.io.outputs import write_bytes
from caricli.limits import MAX_JSON_BYTES, MAX_JSON_DEPTH

_STRING = re.compile(rb'"(?:[^"\\]|\\.)*+"?', re.DOTALL)
_NOT_BRACKET = re.compile(rb"[^\[\]{}]+")


def read_json(path: str | Path) -> Any:
    """Read a JSON file strictly: at most MAX_JSON_BYTES of UTF-8.

    Returns the value; numbers are finite, keys of an object are distinct, nesting is at most MAX_JSON_DEPTH.
    Raises InputError otherwise.
    """
    return parse_json(read_bytes(path, MAX_JSON_BYTES, "a JSON file"), path)


def parse_json(data: bytes, name: object) -> Any:
    """Turn bytes into a JSON value, with the same strictness as `read_json`.

    name: the file, for the message.
    Raises InputError when it is not strict JSON.
    """
    text = decode_text(data, name, "a JSON file")
    brackets = np.frombuffer(_NOT_BRACKET.sub(b"", _STRING.sub(b"", data)), np.uint8)
    steps = np.where((brackets == ord("[")) | (brackets == ord("{")), 1, -1)
    depth = int(np.cumsum(steps).max(initial=0))
    if depth > MAX_JSON_DEPTH:
        raise InputError(f"{shown(name)}: expected JSON nested at most {MAX_JSON_DEPTH} deep, found {depth}")
    try:
        value = json.loads(
            text, object_pairs_hook=_distinct, parse_constant=_refuse_constant, parse_float=_finite, parse_int=_integer
        )
        if "\\u" in text:
            # A lone surrogate is legal JSON but no text that can be printed or written again.
            json.dumps(value, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{shown(name)}: expected strict JSON, found half of a surrogate pair") from None
    except json.JSONDecodeError as error:
        rest = text[error.pos :].strip()
        given = repr(shown(rest, 20)) if rest else "the end of the file"
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"{shown(name)}: {where}: expected strict JSON, found {given} ({error.msg})") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{shown(name)}: expected strict JSON, found {shown(error, 120)}") from None
    return value


def take(parent: dict, key: str, kind: type, default: object = None) -> Any:
    """The value of a key, of one kind. Raises InputError when it is another."""
    value = parent.get(key, default)
    if not isinstance(value, kind):
        raise InputError(f"{shown(key, 40)}: expected {kind.__name__}, found {type(value).__name__}")
    return value


def take_whole(parent: dict, key: str, least: int, most: int, default: int | None = None) -> int:
    """The whole number of a key, from least to most. Raises InputError when it is none."""
    value = parent.get(key, default)
    if type(value) is not int or not least <= value <= most:
        text = shown(value, 40) if isinstance(value, int | float | str) else type(value).__name__
        raise InputError(f"{shown(key, 40)}: expected a whole number from {least} to {most}, found {text}")
    return value


def refuse_others(entry: dict, keys: Sequence[str]) -> None:
    """Refuse an object with another key than these. Raises InputError."""
    others = set(entry) - set(keys)
    if others:
        raise InputError(f"expected only {', '.join(keys)}, found {shown(min(others), 60)!r}")


def found_value(value: Any) -> str:
    """What messages show of a value that was not expected."""
    return "none" if value is None else shown(repr(value), 60)


def write_json(path: str | Path, value: Any) -> None:
    """Write a value as JSON: insertion order, indent 2, UTF-8, a newline at the end.

    value: made of dicts, lists, tuples, strings, numbers, bools, None, paths and NumPy values.
    Raises OutputError when a number is not finite or the file cannot be written.
    """
    write_bytes(path, format_json(value, path).encode("utf-8"))


def format_json(value: Any, name: object, indent: int | None = 2) -> str:
    """The text that `write_json` writes; it ends in a newline.

    name: the file, for the message. indent: spaces, or None for one line.
    Raises OutputError when a number is not finite or a text is not UTF-8.
    """
    try:
        text = json.dumps(value, indent=indent, allow_nan=False, ensure_ascii=False, default=_plain) + "\n"
        text.encode("utf-8")
    except ValueError as error:
        reason = shown(error, 120)
        raise OutputError(f"{shown(name)}: expected finite numbers and UTF-8 text, found: {reason}") from None
    return text


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} has no JSON form")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    value = dict(pairs)
    if len(value) < len(pairs):
        counts = Counter(key for key, _ in pairs)
        key = next(key for key, count in counts.items() if count > 1)
        raise ValueError(f"the key {shown(key, 40)!r} twice")
    return value


def _refuse_constant(text: str) -> float:
    raise ValueError(f"{text}, which is not a number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"the number {shown(text, 40)}, which is too large")
    return value


def _integer(text: str) -> int:
    if len(text) > 40:
        raise ValueError(f"the number {shown(text, 40)}, which is too large")
    return int(text)
