"""The best rotation, translation and scale along three axes between two point sets."""

import numpy as np

ROUNDS = 8
"""Alternations of rotation and scales, after which neither changes."""

_FLAT = 1e-20
"""Of the largest sum of squares: along an axis that has less there is nothing to scale but rounding."""


def axis_similarity(
    source: np.ndarray, target: np.ndarray, uneven: float = np.inf
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Scales s, rotation R and translation t that minimise sum |R diag(s) source + t - target|^2.

    source, target: (N, 3). Where the source is flat along an axis, its scale there is the geometric mean of the
    others. uneven: how many times the smallest scale the largest may be, at least 1.
    Returns (s (3,), R (3, 3) proper, t (3,)).
    """
    source_mean = source.mean(0)
    target_mean = target.mean(0)
    a = source - source_mean
    b = target - target_mean
    size = (a**2).sum(0)
    flat = size <= _FLAT * size.max()
    cross = b.T @ a
    rotation = np.eye(3)
    scales = np.ones(3)
    for _ in range(ROUNDS):
        u, _, vt = np.linalg.svd(cross * scales)
        sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
        rotation = (u * sign) @ vt
        scales = (rotation * cross).sum(0) / np.where(flat, 1.0, size)
        told = scales[~flat]
        middle = np.sqrt(max(told.max(), 0) * max(told.min(), 0)) or np.abs(told).max()
        scales = np.where(flat, middle, np.clip(scales, middle / np.sqrt(uneven), middle * np.sqrt(uneven)))
    return scales, rotation, target_mean - rotation @ (scales * source_mean)
