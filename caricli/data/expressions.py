"""Named expressions: actions with weights."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from caricli.errors import InputError, naming, shown
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.limits import MAX_SHAPES
from caricli.structures.arkit import OPPOSITES

NEUTRAL = "neutral"
"""Name of the expression without actions."""

MAX_WEIGHT = 1.5
"""Largest weight of an action in a user's table: what lies beyond tears faces."""

_SHOWN = 60
"""Characters of a wrong value that a message shows."""


def expand_sides(weights: Mapping[str, float], action_names: Collection[str]) -> dict[str, float]:
    """Give both sides what a name without a side says; what a side's own name says counts the more.

    weights: from ARKit action names, with or without Left or Right, to values in [0, 1]. action_names: those there are.
    Returns weights by full names. Raises InputError for other names.
    """
    expanded = {}
    for name, weight in weights.items():
        sides = [n for n in (name, name + "Left", name + "Right") if n in action_names]
        if not sides:
            raise InputError(f"no ARKit action is named {name!r}")
        if len(sides) == 2 and OPPOSITES.get(sides[0]) == sides[1]:
            raise InputError(f"{name!r}: {sides[0]} and {sides[1]} undo each other; name one of them")
        expanded.update(dict.fromkeys(sides, float(weight)))
    return expanded | {name: float(weight) for name, weight in weights.items() if name in action_names}


def named_expressions(action_names: Collection[str]) -> dict[str, dict[str, float]]:
    """The 25 expressions that datasets show, the neutral one first: names to actions with weights."""
    table = read_yaml(asset_path("expressions.yaml"))
    return {name: expand_sides(weights, action_names) for name, weights in table.items()}


def mouth_shapes(action_names: Collection[str]) -> dict[str, dict[str, float]]:
    """Shapes of a mouth that speaks (``structures.cues.SHAPES``): names to actions with weights."""
    table = read_yaml(asset_path("visemes.yaml"))
    return {name: expand_sides(weights, action_names) for name, weights in table.items()}


def single_expressions(action_names: Collection[str]) -> dict[str, dict[str, float]]:
    """The neutral expression and every action alone."""
    return {NEUTRAL: {}} | {name: {name: 1.0} for name in action_names}


def read_expressions(path: Path, action_names: Collection[str]) -> dict[str, dict[str, float]]:
    """Read expressions: YAML or JSON, names with actions and their weights, among them ``neutral`` without any.

    Returns actions with weights, as of ``expand_sides``, by names, the neutral one first. Raises InputError for
    duplicate names and such as are no text, an unknown action, a weight below 0 or above ``MAX_WEIGHT``, an expression
    without a weight above 0, and where the neutral one is missing or moves.
    """
    table = read_yaml(path)
    with naming(path):
        if not isinstance(table, dict) or not 1 < len(table) <= MAX_SHAPES:
            given = f"{len(table)} entries" if isinstance(table, dict) else shown(table, _SHOWN)
            raise InputError(f"expected 2 to {MAX_SHAPES} names with actions, found {given}")
        neutral = table.pop(NEUTRAL, "none")
        if neutral not in ({}, None):
            given = shown(neutral, _SHOWN)
            raise InputError(f"expected an expression {NEUTRAL!r} without actions, found {given}")
        expressions: dict[str, dict[str, float]] = {NEUTRAL: {}}
        for name, weights in table.items():
            _check_name(name)
            with naming(shown(name, _SHOWN)):
                _check_weights(weights)
                expressions[name] = expand_sides(weights, action_names)
        return expressions


def _check_name(name: Any) -> None:
    if not isinstance(name, str):
        raise InputError(f"expected names that are text, found {shown(name, _SHOWN)}; in YAML write it in quotes")


def _check_weights(weights: Any) -> None:
    if not isinstance(weights, dict) or not weights:
        raise InputError(f"expected actions with weights, found {shown(weights, _SHOWN)}")
    for action, weight in weights.items():
        _check_name(action)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0 <= weight <= MAX_WEIGHT:
            given = f"{shown(action, _SHOWN)}: {shown(weight, _SHOWN)}"
            raise InputError(f"expected weights from 0 to {MAX_WEIGHT}, found {given}")
    if not any(weights.values()):
        raise InputError(f"expected a weight above 0, found {shown(weights, _SHOWN)}")
