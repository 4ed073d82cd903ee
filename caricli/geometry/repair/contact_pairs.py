"""Vertices that touch each other across a gap: lips at rest, lids that close."""

import igl
import numpy as np

from caricli.geometry.vertex_neighbours import vertex_neighbours

FACING = -0.3
"""Cosine between the normals of vertices that face each other: less, so more than 107 degrees."""

APART = 3.0
"""Times as far apart vertices were before they closed."""

RINGS = 4
"""Edges: what is nearer along the surface is one fold, no contact."""


def touching_pairs(vertices: np.ndarray, faces: np.ndarray, reach: float) -> np.ndarray:
    """Pairs of vertices nearer than ``reach`` that face each other, at least ``RINGS`` edges apart on the surface.

    vertices: (V, 3). faces: (F, 3). reach: in their unit.
    Returns (P, 2); every vertex with its nearest partner, each pair once.
    """
    normals = igl.per_vertex_normals(vertices, faces)
    pairs = _near_pairs(vertices, reach)
    offsets = vertices[pairs[:, 0]] - vertices[pairs[:, 1]]
    one, other = normals[pairs[:, 0]], normals[pairs[:, 1]]
    # Back to back, as the two sides of a thin wall, is no contact.
    facing = ((one * other).sum(1) < FACING) & ((offsets * (other - one)).sum(1) > 0)
    pairs = pairs[facing]
    offsets = offsets[facing]
    far = ~_connected(pairs, faces, len(vertices))
    return _nearest(pairs[far], np.linalg.norm(offsets[far], axis=1))


def closing_pairs(before: np.ndarray, after: np.ndarray, faces: np.ndarray, reach: float) -> np.ndarray:
    """Pairs of vertices nearer than ``reach`` after, which were farther than that and ``APART`` times as far before.

    before, after: (V, 3). faces: (F, 3). reach: in their unit.
    Returns (P, 2); every vertex with its nearest partner, each pair once.
    """
    pairs = _near_pairs(after, reach)
    now, then = (np.linalg.norm(v[pairs[:, 0]] - v[pairs[:, 1]], axis=1) for v in (after, before))
    came = closes(then, now, reach)
    pairs = pairs[came]
    now = now[came]
    far = ~_connected(pairs, faces, len(before))
    return _nearest(pairs[far], now[far])


def closes(before: np.ndarray, after: np.ndarray, reach: float) -> np.ndarray:
    """Whether distances come from afar to within reach.

    before, after: (P,) distances. reach: in their unit.
    Returns (P,) bool.
    """
    return (after < reach) & (before > reach) & (before > APART * after)


def _nearest(pairs: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Of pairs (P, 2), those that are the nearest of either of their vertices."""
    nearest = np.full(pairs.max(initial=-1) + 1, np.inf)
    np.minimum.at(nearest, pairs, distances[:, None])
    kept = (distances[:, None] <= nearest[pairs]).any(1)
    return np.unique(np.sort(pairs[kept], axis=1), axis=0)


def _connected(pairs: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """(P,) whether fewer than ``RINGS`` edges lead from one vertex of a pair to the other."""
    if not len(pairs):
        return np.zeros(0, dtype=bool)
    adjacency, _ = vertex_neighbours(faces, count)
    starts, rows = np.unique(pairs[:, 0], return_inverse=True)
    ring = near = adjacency[starts]
    for _ in range(RINGS - 2):
        ring = ring @ adjacency
        near = near + ring
    return np.asarray(near[rows, pairs[:, 1]]).ravel() > 0


def _near_pairs(vertices: np.ndarray, reach: float) -> np.ndarray:
    """(P, 2) all pairs of vertices (V, 3) that are within reach."""
    # Imported here: it takes a while, and what comes of it is mostly kept.
    from scipy.spatial import KDTree

    return KDTree(vertices).query_pairs(reach, output_type="ndarray")
