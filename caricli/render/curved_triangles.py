"""Rounder silhouettes for coarse meshes."""

from collections.abc import Sequence

import numpy as np

_MOST_FACES = 150_000  # a finer mesh takes longer to draw than its roundness is worth
_SHORT_SHARE = 0.9  # of the edges: a few long ones, as on the neck, are left alone
_CREASE = 0.4  # cosine between the normals of an edge's ends, 66 degrees: from there on it stays straight
_FADE = 0.2  # of that cosine, up to 53 degrees: over it an edge comes to be bent in full


def curved_triangles(
    vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, carried: Sequence[np.ndarray] = ()
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
    """Split every triangle in four, the new vertices on the arcs that the normals of an edge's ends suggest.

    Old vertices stay. An edge whose ends' normals differ by more than about 60 degrees, a crease, stays straight.

    vertices: (V, 3). faces: (F, 3). normals: (V, 3), unit length. carried: arrays (V, ...) to interpolate along edges.
    Returns vertices, faces, normals, and the list of carried arrays, of the finer mesh.
    """
    pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64)
    edges, number = np.unique(pairs[:, 0] * len(vertices) + pairs[:, 1], return_inverse=True)
    a, b = np.divmod(edges, len(vertices))
    along = vertices[b] - vertices[a]
    at_a = normals[a]
    at_b = normals[b]
    # An eighth of it puts the middle of a circle's chord back on the circle.
    rise = (along * at_b).sum(1, keepdims=True) * at_b - (along * at_a).sum(1, keepdims=True) * at_a
    bend = np.clip(((at_a * at_b).sum(1, keepdims=True) - _CREASE) / _FADE, 0, 1)
    middle = (vertices[a] + vertices[b]) / 2 + bend * rise / 8
    middle_normals = at_a + at_b
    length = np.linalg.norm(middle_normals, axis=1, keepdims=True)
    middle_normals /= np.where(length > 0, length, 1)
    m = number.reshape(-1, 3) + len(vertices)
    x, y, z = faces.T
    finer = np.concatenate(
        [np.stack(t, 1) for t in ((x, m[:, 0], m[:, 2]), (y, m[:, 1], m[:, 0]), (z, m[:, 2], m[:, 1]), m.T)]
    )
    return (
        np.concatenate([vertices, middle]),
        finer.astype(faces.dtype),
        np.concatenate([normals, middle_normals]),
        [np.concatenate([c, (c[a] + c[b]) / 2]) for c in carried],
    )


def split_long_edges(
    points: np.ndarray, faces: np.ndarray, normals: np.ndarray, carried: Sequence[np.ndarray], longest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Sequence[np.ndarray]]:
    """`curved_triangles` until nine tenths of the edges are short in the picture, or a finer mesh would be too large.

    points: (V, 3) pixels and depth. faces, normals, carried: as in `curved_triangles`. longest: pixels.
    Returns points, faces, normals and carried arrays of the finer mesh.
    """
    while _is_coarse(points, faces, longest):
        points, faces, normals, carried = curved_triangles(points, faces, normals, carried)
    return points, faces, normals, carried


def _is_coarse(points: np.ndarray, faces: np.ndarray, longest: float) -> bool:
    """Whether a tenth of the edges are longer than so many pixels, and a finer mesh is not too large."""
    if 4 * len(faces) > _MOST_FACES:
        return False
    corners = points[:, :2][faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return bool(np.quantile(edges, _SHORT_SHARE) > longest)
