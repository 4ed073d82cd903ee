"""The way of a tongue out of the mouth."""

from collections.abc import Sequence

import numpy as np

from caricli.methods.parts.clear_way import Bends

PARTING = {
    "jawOpen": 0.3,
    "mouthLowerDownLeft": 0.3,
    "mouthLowerDownRight": 0.3,
    "mouthUpperUpLeft": 0.3,
    "mouthUpperUpRight": 0.3,
}
"""Weights of expressions that part lips which leave a tongue no way, and"""
PARTINGS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
"""how often these are taken: as often as needed."""

FLATTEST = 0.75
"""Of the height, and of the width, of a tongue: what it keeps."""

HANGS = 0.4
"""Of its way: how far its tip hangs down where nothing is below it."""

AHEAD = 0.03
"""Of the head's height: how far before the lips its tip is, and"""
LONGEST = 1.0
"""of its way: what is at most added to it for that."""

_ALL = 2
"""Of its changes: the one that raises all of it."""

TIP = 8
"""Power of how far points of a tongue go, of their whole way, by which they count as its tip."""

BETWEEN = 0.5
"""Of the gap between the lips, what a way that ends above or below it is first led to."""


def part_more(names: Sequence[str], deltas: np.ndarray) -> np.ndarray:
    """(V, 3) metres, what parts the lips of a face once. names: K. deltas: (K, V, 3) metres."""
    weights = np.array([PARTING.get(name, 0.0) for name in names])
    return np.tensordot(weights, deltas, 1)


def far_enough(points: np.ndarray, way: np.ndarray, lips: np.ndarray, height: float) -> tuple[np.ndarray, float]:
    """The way of a tongue that comes out between lips (M, 3), lengthened where its tip would stay in.

    points, way: (N, 3) metres, +z out of the mouth. height: metres, of the head.
    Returns the way, and by how much it may be shorter and the tip still be seen, metres.
    """
    length = np.linalg.norm(way, axis=1)
    short = lips[:, 2].max() + AHEAD * height - (points + way)[:, 2].max()
    more = np.clip(short, 0.0, LONGEST * length.max())
    return way + np.outer(length / length.max(), [0.0, 0.0, more]), max(-short, 0.0)


def towards_gap(points: np.ndarray, way: np.ndarray, upper: float, lower: float) -> float:
    """Metres by which the tip of a tongue has to end higher to be between the lips, 0 where it is.

    From above a lip, or below it, the nearest way out of its flesh leads away from the gap. points, way: (N, 3) metres,
    +y up. upper, lower: metres, how high the lips' rims are in their middle.
    """
    weights = (np.linalg.norm(way, axis=1) / np.linalg.norm(way, axis=1).max()) ** TIP
    tip = float(weights @ (points + way)[:, 1] / weights.sum())
    half = BETWEEN * max(upper - lower, 0.0) / 2
    middle = (upper + lower) / 2
    return float(np.clip(tip, middle - half, middle + half)) - tip


def tongue_bends(points: np.ndarray, way: np.ndarray, spare: float, higher: float = 0.0) -> Bends:
    """Changes of a tongue's way out: smooth functions of how far its points go, how high and how far to a side.

    Points that are pressed one by one crumple. Its tip hangs down; it is raised (its back alone, all of it, its tip),
    moved to a side, made flatter and narrower, bent and turned about its length, and comes out less far.

    points: (N, 3) at rest. way: (N, 3) metres, +y up, +z out of the mouth. spare: metres, how much less far. higher:
    metres, how much all of it is raised first.
    """
    length = np.linalg.norm(way, axis=1)
    share = length / length.max()
    middle = points + way
    middle = middle - share @ middle / share.sum()
    width, height, _ = np.abs(middle).max(0)
    side = middle[:, 0] / width
    above = middle[:, 1] / height
    back = share * (1 - share)
    thin = (FLATTEST - 1) * height
    rows: list[tuple[int, np.ndarray, float, float, float]] = [
        (1, share**4, 0.05, -np.inf, -HANGS * length.max()),
        (1, back, 0.1, -np.inf, 0.0),
        (1, share, 0.1, -np.inf, 0.0),
        (1, share**2, 0.1, -np.inf, 0.0),
        (1, share * above, 0.02, thin, 0.0),
        (1, back * above, 0.03, 4 * thin, 0.0),
        (1, share * side**2, 0.03, -np.inf, 0.0),
        (1, share * side, 0.05, -np.inf, 0.0),
        (0, share * side, 0.03, (FLATTEST - 1) * width, 0.0),
        (0, share, 0.03, -np.inf, 0.0),
        (0, back, 0.05, -np.inf, 0.0),
        (2, share, 0.1, -max(spare, 1e-3 * height), 0.0),
    ]
    start = np.zeros(len(rows))
    start[_ALL] = higher
    moves = np.zeros((len(points), 3, len(rows)))
    for k, (axis, amount, *_) in enumerate(rows):
        moves[:, axis, k] = amount
    hold, low, wish = np.array([row[2:] for row in rows]).T
    return Bends(moves, hold, low, wish, start)
