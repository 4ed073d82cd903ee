"""Whether the outside of a surface is outside."""

import numpy as np


def facing_out(vertices: np.ndarray, faces: np.ndarray, middle: np.ndarray) -> float:
    """How far a surface turns its outside away from a place within it; it may be open, torn, and of many pieces.

    vertices: (V, 3). faces: (F, 3), counter-clockwise from outside. middle: (3,).
    Returns a number from -1, where all is inside out, to 1: the cones from the place to the triangles weighed by their
    volumes.
    """
    corners = np.asarray(vertices, float)[faces] - middle
    volumes = np.linalg.det(corners)
    whole = np.abs(volumes).sum()
    return float(volumes.sum() / whole) if whole else 0.0
