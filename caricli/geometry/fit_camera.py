"""The scaled orthographic camera that sees 3D points where a picture shows them."""

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.deformation_gradients import rotation_matrices
from caricli.structures import Camera

_STEPS = 10


def fit_camera(points, pixels, weights=None):
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
    points_mean, pixels_mean = (share * points).sum(0), (share * pixels).sum(0)
    p, q, root = points - points_mean, pixels - pixels_mean, np.sqrt(share)
    affine = np.linalg.lstsq(root * p, root * q, rcond=1e-4)[0].T
    rows = affine / np.maximum(np.linalg.norm(affine, axis=1, keepdims=True), 1e-12)
    u, _, vt = np.linalg.svd(np.vstack([rows, np.cross(rows[0], rows[1])]))
    rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    for _ in range(_STEPS):
        camera = p @ rotation.T
        flat = camera[:, :2]
        scale = (share * flat * q).sum() / (share * flat**2).sum()
        if not (np.isfinite(scale) and scale > 0):
            raise NumericsError("the landmarks do not determine a pose: are they in the order of the scheme?")
        residual = root * (q - scale * flat)
        # Turning by w moves x by w_y z - w_z y and y by w_z x - w_x z.
        zero = np.zeros(len(p))
        turn_x = np.stack([zero, camera[:, 2], -camera[:, 1]], axis=1)
        turn_y = np.stack([-camera[:, 2], zero, camera[:, 0]], axis=1)
        jacobian = np.concatenate(
            [root * np.hstack([scale * turn_x, flat[:, :1]]), root * np.hstack([scale * turn_y, flat[:, 1:]])]
        )
        right = np.concatenate([residual[:, 0], residual[:, 1]])
        change = np.linalg.lstsq(jacobian, right, rcond=1e-8)[0]
        angle = np.linalg.norm(change[:3])
        rotation = rotation_matrices(change[None, :3] * min(1.0, 0.3 / max(angle, 1e-12)))[0] @ rotation
        if angle < 1e-9:
            break
    flat = p @ rotation[:2].T
    scale = (share * flat * q).sum() / (share * flat**2).sum()
    return Camera(float(scale), rotation, pixels_mean - scale * rotation[:2] @ points_mean)


def _in_one_place(values):
    return len(values) == 0 or np.ptp(values, axis=0).max() <= 1e-9 * np.abs(values).max()
