"""The best similarity transform between two point sets."""

import numpy as np


def similarity(source: np.ndarray, target: np.ndarray, scaling: bool = True) -> tuple[float, np.ndarray, np.ndarray]:
    """Scale s, rotation R and translation t that minimise sum |s R source + t - target|^2 (Umeyama 1991).

    source, target: (N, D). scaling: whether s may differ from one.
    Returns (s, R (D, D) proper, t (D,)).
    """
    source_mean = source.mean(0)
    target_mean = target.mean(0)
    a = source - source_mean
    b = target - target_mean
    u, singular, vt = np.linalg.svd(b.T @ a)
    sign = np.ones(len(singular))
    sign[-1] = np.sign(np.linalg.det(u @ vt))
    rotation = (u * sign) @ vt
    scale = (singular * sign).sum() / (a**2).sum() if scaling else 1.0
    return scale, rotation, target_mean - scale * rotation @ source_mean
