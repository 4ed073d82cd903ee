"""Many similarity transforms at once."""

import numpy as np


def weighted_similarities(
    source: np.ndarray, target: np.ndarray, weights: np.ndarray, scaling: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Scales s, rotations R and translations t that minimise sum_n w_n |s R source_n + t - target_n|^2 (Umeyama 1991).

    source, target: (..., N, 3). weights: (..., N), not negative. scaling: whether scales may differ from one. Leading
    dimensions are broadcast.
    Returns s (...), R (..., 3, 3) proper, t (..., 3). Where all sources lie in one place, s and R are one.
    """
    share = (weights / weights.sum(-1, keepdims=True))[..., None]
    source_mean = (share * source).sum(-2)
    target_mean = (share * target).sum(-2)
    a = source - source_mean[..., None, :]
    b = target - target_mean[..., None, :]
    u, singular, vt = np.linalg.svd(np.swapaxes(share * b, -1, -2) @ a)
    sign = np.ones(singular.shape)
    sign[..., 2] = np.where(np.linalg.det(u @ vt) < 0, -1.0, 1.0)
    rotation = (u * sign[..., None, :]) @ vt
    size = (share * a**2).sum((-2, -1))
    scale = np.where(size > 0, (singular * sign).sum(-1) / np.where(size > 0, size, 1.0), 1.0)
    if not scaling:
        scale = np.ones_like(scale)
    return scale, rotation, target_mean - scale[..., None] * (rotation @ source_mean[..., None])[..., 0]
