"""Normals of triangles."""

import numpy as np


def triangle_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Cross products of the triangles' edges: direction the normal, length twice the area.

    vertices: (..., V, 3). faces: (F, 3).
    Returns (..., F, 3).
    """
    corner = vertices[..., faces[:, 0], :]
    return np.cross(vertices[..., faces[:, 1], :] - corner, vertices[..., faces[:, 2], :] - corner)
