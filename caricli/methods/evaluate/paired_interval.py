"""How much a method differs from another on the same faces, and how sure that is."""

import numpy as np

from caricli.methods.evaluate.ratio_interval import ratio_interval


def paired_interval(differences: np.ndarray, people: np.ndarray) -> dict[str, float]:
    """The mean of differences and its ``ratio_interval``.

    differences: (N,) of faces; NaN where there is none. people: (N,) who they are.
    Returns mean, low and high; nothing where there are no differences.
    """
    there = np.isfinite(differences)
    if not there.any():
        return {}
    figures = ratio_interval(differences[there], np.ones(there.sum()), people[there])
    return dict(zip(("mean", "low", "high"), figures, strict=True))
