"""Weights of a track to weights of a rig, by name."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.track import MAX_WEIGHTS


@dataclass(frozen=True, eq=False)
class BoundWeights:
    """weights (T, K) as the rig orders them; unmatched, what it lacks; undriven, of the rig's what no column moves."""

    weights: np.ndarray
    unmatched: tuple
    undriven: tuple


def bind_weights(track, names):
    """Bind weights by name, never by order.

    A name binds to the same name, else to the one that differs in the case of the first letter alone.
    track: Track. names: the rig's (K,).
    Returns BoundWeights; what nothing drives stays 0.
    Raises InputError when no name is common, two names of the track bind to one of the rig, or frames times shapes are
    too many.
    """
    columns, unmatched = {}, []
    for column, name in enumerate(track.names):
        target = next((n for n in (name, name[:1].swapcase() + name[1:]) if n in names), None)
        if target is None:
            unmatched.append(name)
        elif target in columns:
            raise InputError(f"weights: expected one column for {shown(target, 40)!r}, found it in either spelling")
        else:
            columns[target] = column
    if not columns:
        ours, theirs = (shown(", ".join(n[:3]), 60) for n in (names, track.names))
        raise InputError(f"weights: expected names of the rig, such as {ours}; found none of them, but {theirs}")
    if len(track.times) * len(names) > MAX_WEIGHTS:
        found = f"{len(track.times)} frames of {len(names)} shapes"
        raise InputError(f"weights: expected at most {MAX_WEIGHTS} numbers, found {found}")
    weights = np.zeros((len(track.times), len(names)))
    for k, name in enumerate(names):
        if name in columns:
            weights[:, k] = track.weights[:, columns[name]]
    return BoundWeights(weights, tuple(unmatched), tuple(name for name in names if name not in columns))
