"""Triangles without an area."""

import numpy as np

from caricli.geometry.triangle_normals import triangle_normals

_FLAT = 1e-10
"""Of the mean area: a triangle with less has no direction."""


def flat_triangles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Find the triangles whose area is next to none of the mean one.

    vertices: (V, 3). faces: (F, 3).
    Returns (F,) bool.
    """
    areas = np.linalg.norm(triangle_normals(vertices, faces), axis=1)
    return areas <= _FLAT * areas.mean()
