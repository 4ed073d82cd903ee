"""Medians of what counts differently."""

import numpy as np


def weighted_medians(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Of every column the value at which half of all weight is reached.

    values: (N, C). weights: (N,), none negative. Returns (C,).
    """
    order = np.argsort(values, axis=0)
    total = np.cumsum(weights[order], axis=0)
    at = (total < total[-1] / 2).sum(0)
    return np.take_along_axis(values, np.take_along_axis(order, at[None], 0), 0)[0]
