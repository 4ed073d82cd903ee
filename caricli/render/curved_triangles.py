"""Rounder silhouettes for coarse meshes."""

import numpy as np


def curved_triangles(vertices, faces, normals, carried=()):
    """Split every triangle in four, the new vertices on the arcs that the normals of an edge's ends suggest.

    Old vertices stay. An edge whose ends' normals differ by more than about 60 degrees, a crease, stays straight.
    vertices: (V, 3). faces: (F, 3). normals: (V, 3), unit length. carried: arrays (V, ...) to interpolate along edges.
    Returns vertices, faces, normals, and the list of carried arrays, of the finer mesh.
    """
    pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64)
    edges, number = np.unique(pairs[:, 0] * len(vertices) + pairs[:, 1], return_inverse=True)
    a, b = edges // len(vertices), edges % len(vertices)
    along = vertices[b] - vertices[a]
    na, nb = normals[a], normals[b]
    # An eighth of it puts the middle of a circle's chord back on the circle.
    rise = (along * nb).sum(1, keepdims=True) * nb - (along * na).sum(1, keepdims=True) * na
    bend = np.clip(((na * nb).sum(1, keepdims=True) - 0.4) / 0.2, 0, 1)
    middle = (vertices[a] + vertices[b]) / 2 + bend * rise / 8
    middle_normals = na + nb
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
