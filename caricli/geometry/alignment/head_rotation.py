"""A head that is turned before the camera."""

import numpy as np

from caricli.geometry.alignment.rotation_vectors import rotation_matrices

TURNS = np.radians([12.0, 30.0, 12.0])
"""Pitch, yaw and roll of heads in pictures, at most."""


def head_rotation(angles: np.ndarray) -> np.ndarray:
    """Rotation from a face's axes to a camera's before it (x right, y down, z into the picture).

    angles: (3,) pitch, yaw and roll in radians.
    Returns (3, 3).
    """
    pitch, yaw, roll = rotation_matrices(np.diag(angles))
    return roll @ pitch @ yaw @ np.diag([1.0, -1.0, -1.0])


def head_angles(rotation: np.ndarray) -> np.ndarray:
    """The inverse of ``head_rotation``: pitch, yaw and roll (3,) in radians, the pitch at most a right angle."""
    turned = rotation @ np.diag([1.0, -1.0, -1.0])
    pitch = np.arcsin(np.clip(turned[2, 1], -1, 1))
    yaw = np.arctan2(-turned[2, 0], turned[2, 2])
    roll = np.arctan2(-turned[0, 1], turned[1, 1])
    return np.array([pitch, yaw, roll])
