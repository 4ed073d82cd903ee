"""A ratio of sums over faces, and how sure it is."""

import numpy as np

DRAWS = 2000
"""Of people, for an interval."""


def ratio_interval(
    above: np.ndarray, below: np.ndarray, people: np.ndarray, draws: int = DRAWS, seed: int = 0
) -> tuple[float, float, float]:
    """``sum(above) / sum(below)`` and what 95 % of its values lie between when people are drawn anew (bootstrap).

    Faces of one person are drawn together, because they tell less than as many strangers.

    above, below: (N,) of faces, below not negative. people: (N,) who they are. draws: how many. seed: of these.
    Returns the ratio, low and high.
    """
    who = np.unique(people, return_inverse=True)[1]
    top, base = (np.bincount(who, values) for values in (above, below))
    drawn = np.random.default_rng(seed).integers(len(top), size=(draws, len(top)))
    low, high = np.percentile(_ratio(top[drawn].sum(1), base[drawn].sum(1)), [2.5, 97.5])
    return float(_ratio(top.sum(), base.sum())), float(low), float(high)


def _ratio(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    return above / np.maximum(below, 1e-12)
