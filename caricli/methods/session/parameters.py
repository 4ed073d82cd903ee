"""Parameters of operations, checked."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from caricli.errors import InputError, shown
from caricli.limits import MAX_COORDINATE, MAX_SKETCH_POINTS

Parameters = Mapping[str, Any]

_MOST = 100
"""Texts of a list, and numbers by names, where nothing else is said."""


def only(parameters: Parameters, *names: str) -> None:
    """Refuse parameters of other names than these."""
    others = set(parameters) - set(names)
    if others:
        expected = f"only {', '.join(names)}" if names else "no parameters"
        raise InputError(f"expected {expected}, found {shown(min(others), 60)!r}")


def number(parameters: Parameters, name: str, least: float, most: float, default: float | None = None) -> float:
    """A number from least to most. Raises InputError when it is none, or not there and without a default."""
    value = parameters.get(name, default)
    if type(value) not in (int, float) or not least <= value <= most:
        raise InputError(f"{name}: expected a number from {least:g} to {most:g}, found {shown(repr(value), 60)}")
    return float(value)


def choice(parameters: Parameters, name: str, choices: Sequence[str], default: str | None = None) -> str:
    """One of some texts. Raises InputError."""
    value = parameters.get(name, default)
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name}: expected one of {', '.join(choices)}, found {shown(repr(value), 60)}")
    return value


def switch(parameters: Parameters, name: str) -> bool:
    """True or false, false where it is not there. Raises InputError."""
    value = parameters.get(name, False)
    if not isinstance(value, bool):
        raise InputError(f"{name}: expected true or false, found {shown(repr(value), 60)}")
    return value


def texts(parameters: Parameters, name: str, most: int = _MOST) -> list[str]:
    """A list of texts, none where it is not there. Raises InputError."""
    value = parameters.get(name, [])
    if not isinstance(value, list) or len(value) > most or not all(isinstance(each, str) for each in value):
        raise InputError(f"{name}: expected a list of at most {most} texts, found {shown(repr(value), 60)}")
    return value


def numbers(parameters: Parameters, name: str, most: float) -> dict[str, float]:
    """Numbers by names, of a magnitude of at most ``most``. Raises InputError."""
    value = parameters.get(name)
    if not isinstance(value, dict) or not 0 < len(value) <= _MOST:
        raise InputError(f"{name}: expected 1 to {_MOST} numbers by names, found {shown(repr(value), 60)}")
    return {key: number(value, key, -most, most) for key in value}


def points(parameters: Parameters, name: str, columns: int = 2) -> np.ndarray:
    """(N, columns) float64, at least one row. Raises InputError."""
    rows = parameters.get(name)
    if not isinstance(rows, list) or not 0 < len(rows) <= MAX_SKETCH_POINTS:
        raise InputError(f"{name}: expected 1 to {MAX_SKETCH_POINTS} points, found {shown(repr(rows), 60)}")
    flat = [x for row in rows if isinstance(row, list) and len(row) == columns for x in row]
    if len(flat) != columns * len(rows) or not all(type(x) in (int, float) for x in flat):
        raise InputError(f"{name}: expected rows of {columns} numbers, found others")
    if not all(abs(x) <= MAX_COORDINATE for x in flat):
        raise InputError(f"{name}: expected coordinates of at most {MAX_COORDINATE:g}, found larger ones")
    return np.array(flat, np.float64).reshape(-1, columns)
