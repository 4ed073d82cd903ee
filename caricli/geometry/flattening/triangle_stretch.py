"""How a surface is stretched where it is laid into a plane."""

import numpy as np


def inverse_edges(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Inverses of the edges of triangles in coordinates of their own.

    vertices: (V, 3). faces: (F, 3), none without area.
    Returns (F, 2, 2): times the edges (F, 2, 2) of the laid triangles, as columns, they are the maps between.
    """
    first, second = (vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))
    along = np.linalg.norm(first, axis=1)
    edges = np.zeros((len(faces), 2, 2))
    edges[:, 0, 0] = along
    edges[:, 0, 1] = (first * second).sum(1) / along
    edges[:, 1, 1] = np.linalg.norm(np.cross(first, second), axis=1) / along
    return np.linalg.inv(edges)


def plane_maps(inverse: np.ndarray, faces: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Linear maps (F, 2, 2) from triangles, whose edges have the inverses (F, 2, 2), to their places (V, 2)."""
    edges = places[faces[:, 1:]] - places[faces[:, :1]]
    return edges.transpose(0, 2, 1) @ inverse


def triangle_stretch(vertices: np.ndarray, faces: np.ndarray, uvs: np.ndarray, uv_faces: np.ndarray) -> np.ndarray:
    """Singular values of the maps from a surface to a picture.

    vertices: (V, 3). faces: (F, 3), none without area. uvs: (T, 2). uv_faces: (F, 3), the same triangles in the
    picture.
    Returns (F, 2): the larger one, and the smaller one, negative where a triangle is turned over. Their product is the
    ratio of the areas, their quotient the quasi-conformal error, 1 where angles are kept.
    """
    maps = plane_maps(inverse_edges(vertices, faces), uv_faces, uvs)
    values = np.linalg.svd(maps, compute_uv=False)
    values[:, 1] *= np.where(np.linalg.det(maps) < 0, -1, 1)
    return values
