"""A head that is turned before the camera."""

import numpy as np

from caricli.geometry.rotation_vectors import rotation_matrices

TURNS = np.radians([12.0, 30.0, 12.0])
"""Pitch, yaw and roll of heads in pictures, at most."""


def head_rotation(angles: np.ndarray) -> np.ndarray:
    """Rotation from a face's axes to a camera's before it (x right, y down, z into the picture).

    angles: (3,) pitch, yaw and roll in radians.
    Returns (3, 3).
    """
    pitch, yaw, roll = rotation_matrices(np.diag(angles))
    return roll @ pitch @ yaw @ np.diag([1.0, -1.0, -1.0])
