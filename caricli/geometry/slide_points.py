"""Points of a line, moved along it."""

import numpy as np

_LEAST = 1e-6
"""Distance that two neighbours have at least, of the line's length."""


def line_shares(points: np.ndarray) -> np.ndarray:
    """(K,) shares of the length of a line (K, 2), 0 to 1 and rising, at which its points stand.

    Two that fall together count as a little apart.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps = np.maximum(steps, max(_LEAST * steps.sum(), np.finfo(float).tiny))
    along = np.concatenate([[0], np.cumsum(steps)])
    return along / along[-1]


def slide_points(points: np.ndarray, shares: np.ndarray, own: np.ndarray | None = None) -> np.ndarray:
    """Points (K, 2) of a line, moved along it to shares (K,).

    own: (K,) rising shares at which they stand, or None for those of its length. Between the points the line is smooth
    and does not swing (Fritsch and Carlson 1980).
    """
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(line_shares(points) if own is None else own, points)(shares)
