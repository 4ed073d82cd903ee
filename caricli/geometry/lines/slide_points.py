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

    own: (K,) rising shares at which they stand, or None for those of its length. Between the points the line is a cubic
    that is smooth and does not swing (Fritsch and Carlson 1980), as `scipy.interpolate.PchipInterpolator`, whose import
    takes as long as half a detection.
    """
    own = line_shares(points) if own is None else own
    steps = np.diff(own)[:, None]
    rises = np.diff(points, axis=0) / steps
    slopes = np.concatenate(
        [_end_slope(steps, rises), _inner_slopes(steps, rises), _end_slope(steps[::-1], rises[::-1])]
    )
    piece = np.clip(np.searchsorted(own, shares, "right") - 1, 0, len(steps) - 1)
    step = steps[piece]
    way = (np.asarray(shares) - own[piece])[:, None] / step
    start, end = points[piece], points[piece + 1]
    bent = (1 - way) * slopes[piece] - way * slopes[piece + 1] + (2 * way - 1) * rises[piece]
    return start + way * (end - start) + way * (1 - way) * step * bent


def _inner_slopes(steps: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """(K - 2, 2) slopes at points between others, zero at turns: harmonic means (Fritsch and Butland 1984).

    steps: (K - 1, 1) from point to point. rises: (K - 1, 2) slopes of the straight lines there.
    """
    first = 2 * steps[1:] + steps[:-1]
    second = steps[1:] + 2 * steps[:-1]
    before, after = rises[:-1], rises[1:]
    level = before * after <= 0
    means = (first + second) / (first / np.where(level, 1, before) + second / np.where(level, 1, after))
    return np.where(level, 0, means)


def _end_slope(steps: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """(1, 2) slope at the first point: of the parabola through three, not so steep that it swings."""
    if len(rises) == 1:
        return rises
    slope = ((2 * steps[0] + steps[1]) * rises[0] - steps[0] * rises[1]) / (steps[0] + steps[1])
    slope = np.where(slope * rises[0] <= 0, 0, slope)
    turns = (rises[0] * rises[1] <= 0) & (np.abs(slope) > 3 * np.abs(rises[0]))
    return np.where(turns, 3 * rises[0], slope)[None]
