"""How landmarks in a picture change with camera and shape."""

import numpy as np

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.structures import Camera

CAMERA = 6
"""Unknowns of a camera: turn (3), logarithm of the scale, shift (2)."""


def camera_rows(positions: np.ndarray, jacobian: np.ndarray, camera: Camera) -> np.ndarray:
    """Derivatives of projected positions by a step of the camera and the latent.

    positions: (K, 3). jacobian: (K, 3, D), their derivatives by the latent. camera: Camera.
    Returns (K, 2, 6 + D).
    """
    turned = positions @ camera.rotation.T
    rows = np.zeros((len(positions), 2, CAMERA + jacobian.shape[2]))
    rows[:, 0, 1] = turned[:, 2]
    rows[:, 0, 2] = -turned[:, 1]
    rows[:, 1, 0] = -turned[:, 2]
    rows[:, 1, 2] = turned[:, 0]
    rows[:, :, 3] = turned[:, :2]
    rows[:, :, CAMERA:] = np.einsum("ab,kbd->kad", camera.rotation[:2], jacobian)
    rows *= camera.scale
    rows[:, 0, 4] = 1.0
    rows[:, 1, 5] = 1.0
    return rows


def moved_camera(camera: Camera, step: np.ndarray) -> Camera:
    """The camera turned, scaled and shifted by a step (6,)."""
    rotation = rotation_matrices(step[None, :3])[0] @ camera.rotation
    return Camera(camera.scale * float(np.exp(step[3])), rotation, camera.translation + step[4:])
