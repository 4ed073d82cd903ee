"""Named expressions: actions with weights."""

from numbers import Real

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.io.strict_json import read_json
from caricli.limits import MAX_SHAPES

NEUTRAL, MOST = "neutral", 1.5


def expand_sides(weights, action_names):
    """Give both sides what a name without a side says.

    weights: dict from ARKit action names, with or without Left or Right, to values in [0, 1]. action_names: the known.
    Returns dict from full names. Raises InputError for unknown names.
    """
    expanded = {}
    for name, weight in weights.items():
        sides = [n for n in (name, name + "Left", name + "Right") if n in action_names]
        if not sides:
            raise InputError(f"no ARKit action is named {name!r}")
        expanded.update(dict.fromkeys(sides, float(weight)))
    return expanded


def facs_expressions(action_names):
    """The neutral expression and the 46 FACS-style ones, those of them that are among the actions. Returns a dict."""
    facs = read_json(asset_path("facs.json"))
    return {NEUTRAL: {}} | {name: {name: 1.0} for name in action_names if facs.get(name, {}).get("facs46")}


def read_expressions(path, action_names):
    """Read expressions: YAML or JSON, names with actions and their weights, among them ``neutral`` without any.

    Returns a dict, the neutral one first, from names to dicts as of ``expand_sides``. Raises InputError for duplicate
    names, an unknown action, a weight below 0 or above ``MOST``, and where the neutral one is missing or moves.
    """
    table, where = read_yaml(path), shown(path)
    if not isinstance(table, dict) or not 1 < len(table) <= MAX_SHAPES:
        found = f"{len(table)} entries" if isinstance(table, dict) else shown(table, 60)
        raise InputError(f"{where}: expected 2 to {MAX_SHAPES} names with actions, found {found}")
    if table.get(NEUTRAL, "none") not in ({}, None):
        found = shown(table.get(NEUTRAL, "none"), 60)
        raise InputError(f"{where}: expected an expression {NEUTRAL!r} without actions, found {found}")
    expressions = {NEUTRAL: {}}
    for name, weights in table.items():
        if name == NEUTRAL:
            continue
        if not isinstance(weights, dict) or not weights:
            raise InputError(f"{where}: {shown(name, 60)}: expected actions with weights, found {shown(weights, 60)}")
        for action, weight in weights.items():
            if isinstance(weight, bool) or not isinstance(weight, Real) or not 0 <= weight <= MOST:
                found = f"{shown(action, 60)}: {shown(weight, 60)}"
                raise InputError(f"{where}: {shown(name, 60)}: expected weights from 0 to {MOST}, found {found}")
        try:
            expressions[name] = expand_sides(weights, action_names)
        except InputError as error:
            raise InputError(f"{where}: {shown(name, 60)}: {error}") from error
    return expressions
