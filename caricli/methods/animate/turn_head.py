"""The turning of a head from the angles that a face tracker gives."""

import numpy as np
from scipy.spatial.transform import Rotation


def turn_head(angles: np.ndarray) -> np.ndarray:
    """Rotations about the origin of the face frame, ``R = R_y(yaw) R_x(pitch) R_z(roll)``.

    Epic publishes no signs for Live Link Face. Here they are right-handed in the axes of ARKit's face anchor, which are
    those of the face frame (+x the face's left, +y up, +z out of the face): positive yaw turns to the face's own left,
    positive pitch nods down, positive roll leans to its own right shoulder.

    angles: (T, 3) yaw, pitch, roll in radians.
    Returns (T, 4) unit quaternions xyzw, each in the half-space of the one before, so that steps are the short way.
    """
    turns = Rotation.from_euler("YXZ", np.asarray(angles, float)).as_quat()
    against = (turns[1:] * turns[:-1]).sum(1) < 0
    turns[1:] *= np.where(np.cumsum(against) % 2, -1, 1)[:, None]
    return turns


def within_half_turns(angles: np.ndarray) -> np.ndarray:
    """The same turns by angles (T, 3) from minus half a turn to half a turn, radians."""
    return angles - 2 * np.pi * np.round(angles / (2 * np.pi))
