"""How much a method differs from another on the same faces, and how sure that is."""

import numpy as np

DRAWS = 2000
"""Of people, for an interval."""


def paired_interval(differences: np.ndarray, people: np.ndarray, seed: int = 0) -> dict[str, float]:
    """The mean of differences and what 95 % of its values lie between when people are drawn anew (bootstrap).

    Faces of one person are drawn together, because they tell less than as many strangers.

    differences: (N,) of faces; NaN where there is none. people: (N,) who they are. seed: of the draws.
    Returns mean, low and high; nothing where there are no differences.
    """
    there = np.isfinite(differences)
    if not there.any():
        return {}
    _, owner = np.unique(people[there], return_inverse=True)
    sums = np.bincount(owner, differences[there])
    counts = np.bincount(owner)
    drawn = np.random.default_rng(seed).integers(len(sums), size=(DRAWS, len(sums)))
    low, high = np.percentile(sums[drawn].sum(1) / counts[drawn].sum(1), [2.5, 97.5])
    return {"mean": float(sums.sum() / counts.sum()), "low": float(low), "high": float(high)}
