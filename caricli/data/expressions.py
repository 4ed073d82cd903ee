"""The named expressions of a dataset."""

from caricli.errors import InputError


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
