"""Normals for smooth shading, and for light that is told from pictures."""

import numpy as np

from caricli.geometry.places_of import places_of


def smooth_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals of vertices, averaged over their triangles by corner angle.

    Vertices at the same place share a normal, so that a mesh split along the borders of its texture shows no seam.
    vertices: (V, 3). faces: (F, 3), counter-clockwise from outside.
    Returns (V, 3) float64; (0, 0, 0) where a vertex has no triangle with an area.
    """
    place = places_of(vertices)
    corners = vertices[faces]
    edges = [corners[:, (k + 1) % 3] - corners[:, k] for k in range(3)]
    normals = np.cross(edges[0], -edges[2])
    # Twice the area, which is the sine of every corner's angle times its two edges.
    length = np.linalg.norm(normals, axis=1)
    normals /= np.where(length > 0, length, 1)[:, None]
    angles = [np.arctan2(length, -(edges[k] * edges[k - 1]).sum(1)) for k in range(3)]
    return _mean_directions(place, faces, [angle[:, None] * normals for angle in angles])


def even_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The same, each the mean of those at the corners of its triangles.

    Light that is told from a picture is told by them, and taken out: a fold of a fitted surface is easily beside that
    of the picture. Arguments and result are those of `smooth_normals`.
    """
    around = smooth_normals(vertices, faces)[faces].sum(1)
    return _mean_directions(places_of(vertices), faces, [around] * 3)


def _mean_directions(place: np.ndarray, faces: np.ndarray, given: list[np.ndarray]) -> np.ndarray:
    """Unit vectors (V, 3) of vertices at places (V,), along the sum of what faces (F, 3) give their corners.

    given: three times (F, 3), one for each corner.
    """
    total = np.zeros((len(place), 3))
    for k, vectors in enumerate(given):
        at = place[faces[:, k]]
        for axis in range(3):
            total[:, axis] += np.bincount(at, vectors[:, axis], len(place))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.where(length > 0, length, 1))[place]
