"""Weights of a track to weights of a rig, by name."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.takes.track import MAX_WEIGHTS
from caricli.structures import Track
from caricli.structures.arkit import arkit_name, arkit_sides, is_half


@dataclass(frozen=True, eq=False)
class BoundWeights:
    """Weights as a rig has them.

    weights: (T, K) in the rig's order.
    unmatched: names of the track that the rig lacks.
    undriven: names of the rig that no column moves.
    """

    weights: np.ndarray
    unmatched: tuple[str, ...]
    undriven: tuple[str, ...]


def bind_weights(track: Track, names: Sequence[str]) -> BoundWeights:
    """Bind weights by name, never by order.

    A name binds to the same name, else to the one that differs in the case of the first letter alone, else to those
    that mean the same action of ARKit (``arkit_name``), both halves of it where the rig has halves. A name that ARKit
    has with Left and Right alone, such as ``mouthSmile``, binds to both, or to the one that the rig has; a column of a
    side's own name counts the more.

    names: the rig's (K,).
    Returns BoundWeights; what nothing drives stays 0.
    Raises InputError when no name is common, two names of the track bind to one of the rig, or frames times shapes are
    too many.
    """
    columns, unmatched = _columns(track.names, names)
    if not columns:
        ours = shown(", ".join(names[:3]), 60)
        theirs = shown(", ".join(track.names[:3]), 60)
        raise InputError(f"weights: expected names of the rig, such as {ours}; found none of them, but {theirs}")
    if len(track.times) * len(names) > MAX_WEIGHTS:
        size = f"{len(track.times)} frames of {len(names)} shapes"
        raise InputError(f"weights: expected at most {MAX_WEIGHTS} numbers, found {size}")
    weights = np.zeros((len(track.times), len(names)))
    for k, name in enumerate(names):
        if name in columns:
            weights[:, k] = track.weights[:, columns[name]]
    return BoundWeights(weights, tuple(unmatched), tuple(name for name in names if name not in columns))


def _columns(theirs: Sequence[str], ours: Sequence[str]) -> tuple[dict[str, int], list[str]]:
    """Columns of a track by the rig's names, and names that the rig lacks."""
    columns: dict[str, int] = {}
    of_sides: dict[str, int] = {}
    unmatched = []
    for column, name in enumerate(theirs):
        targets = _targets(name, ours)
        sides = [] if targets else _sides(name, ours)
        if not targets and not sides:
            unmatched.append(name)
        _bind(columns, targets, column)
        _bind(of_sides, sides, column)
    return of_sides | columns, unmatched


def _bind(columns: dict[str, int], targets: Sequence[str], column: int) -> None:
    """Add a column, under every name of the rig that it drives. Raises InputError where one has a column already."""
    for target in targets:
        if target in columns:
            raise InputError(f"weights: expected one column for {shown(target, 40)!r}, found it in either spelling")
        columns[target] = column


def _targets(name: str, ours: Sequence[str]) -> list[str]:
    """The rig's names that a name of a track drives."""
    for spelling in (name, name[:1].swapcase() + name[1:]):
        if spelling in ours:
            return [spelling]
    whole = None if is_half(name) else arkit_name(name)
    alike = [own for own in ours if whole and arkit_name(own) == whole]
    # Where the rig has the whole action its halves are somebody else's.
    return [own for own in alike if not is_half(own)] or alike


def _sides(name: str, ours: Sequence[str]) -> list[str]:
    """The rig's names of the left and the right action that a name without a side stands for, as far as it has them."""
    sides = arkit_sides(name) or ()
    return [own for own in ours if arkit_name(own) in sides]
