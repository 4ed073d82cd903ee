"""The scaled orthographic camera that sees 3D points where a picture shows them."""

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.structures import Camera

_STEPS = 10  # at most
_WIDEST = 0.3  # radians that one step may turn: beyond, the linear model means little
_SETTLED = 1e-9  # radians


def fit_camera(points: np.ndarray, pixels: np.ndarray, weights: np.ndarray | None = None) -> Camera:
    """Fit a camera to 3D-2D correspondences.

    Starts from the affine fit (Kemelmacher-Shlizerman and Seitz 2011, section 3.2) made orthonormal, with scale and
    translation solved again for that rotation, and refines ``sum_k w_k |s R[:2] p_k + t - q_k|^2`` by Gauss-Newton.

    points: (K, 3), not all in one plane. pixels: (K, 2). weights: (K,) not negative.
    Returns Camera. Raises NumericsError where the correspondences do not determine it.
    """
    weights = np.ones(len(points)) if weights is None else weights
    if any(_in_one_place(values[weights > 0]) for values in (points, pixels)):
        raise NumericsError("the landmarks lie in one place: no pose can be found")
    share = (weights / weights.sum())[:, None]
    points_mean = (share * points).sum(0)
    pixels_mean = (share * pixels).sum(0)
    p = points - points_mean
    q = pixels - pixels_mean
    rotation = _affine_rotation(p, q, share)
    for _ in range(_STEPS):
        turn = _turn(p @ rotation.T, q, share)
        angle = float(np.linalg.norm(turn))
        rotation = rotation_matrices(turn[None] * min(1.0, _WIDEST / max(angle, 1e-12)))[0] @ rotation
        if angle < _SETTLED:
            break
    scale = _scale(p @ rotation[:2].T, q, share)
    return Camera(float(scale), rotation, pixels_mean - scale * rotation[:2] @ points_mean)


def _affine_rotation(p: np.ndarray, q: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The rotation nearest to the affine map of points (K, 3) to pixels (K, 2), both about their means."""
    root = np.sqrt(share)
    affine = np.linalg.lstsq(root * p, root * q, rcond=1e-4)[0].T
    rows = affine / np.maximum(np.linalg.norm(affine, axis=1, keepdims=True), 1e-12)
    u, _, vt = np.linalg.svd(np.vstack([rows, np.cross(rows[0], rows[1])]))
    return u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt


def _scale(flat: np.ndarray, q: np.ndarray, share: np.ndarray) -> float:
    """The scale that takes turned points (K, 2) nearest to pixels (K, 2)."""
    return (share * flat * q).sum() / (share * flat**2).sum()


def _turn(turned: np.ndarray, q: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Rotation vector (3,) of the full Gauss-Newton step in rotation and scale, from turned points (K, 3)."""
    root = np.sqrt(share)
    flat = turned[:, :2]
    scale = _scale(flat, q, share)
    if not (np.isfinite(scale) and scale > 0):
        raise NumericsError("the landmarks do not determine a pose: are they in the order of the scheme?")
    residual = root * (q - scale * flat)
    # Turning by w moves x by w_y z - w_z y and y by w_z x - w_x z.
    zero = np.zeros(len(turned))
    turn_x = np.stack([zero, turned[:, 2], -turned[:, 1]], axis=1)
    turn_y = np.stack([-turned[:, 2], zero, turned[:, 0]], axis=1)
    jacobian = np.concatenate(
        [root * np.hstack([scale * turn_x, flat[:, :1]]), root * np.hstack([scale * turn_y, flat[:, 1:]])]
    )
    return np.linalg.lstsq(jacobian, np.concatenate([residual[:, 0], residual[:, 1]]), rcond=1e-8)[0][:3]


def _in_one_place(values: np.ndarray) -> bool:
    return len(values) == 0 or np.ptp(values, axis=0).max() <= 1e-9 * np.abs(values).max()
