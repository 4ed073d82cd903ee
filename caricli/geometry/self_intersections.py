"""Triangles of one mesh that go through each other."""

import numpy as np
from scipy.spatial import cKDTree

_PARALLEL = 1e-12  # sine of the angle between an edge and a plane: with less they do not meet


def self_intersections(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Find pairs of triangles without a common corner, an edge of one of which goes through the other.

    vertices: (V, 3). faces: (F, 3).
    Returns (K, 2) triangle numbers, the smaller first, in order.
    """
    corners = vertices[faces]
    pairs = _near_pairs(corners)
    low, high = corners.min(1), corners.max(1)
    first, second = pairs.T
    overlap = ((low[first] <= high[second]) & (low[second] <= high[first])).all(1)
    pairs = pairs[overlap]
    first, second = pairs.T
    apart = (faces[first][:, :, None] != faces[second][:, None]).all((1, 2))
    pairs = pairs[apart]
    triangles = corners[pairs[:, 0]]
    others = corners[pairs[:, 1]]
    hit = _an_edge_pierces(triangles, others) | _an_edge_pierces(others, triangles)
    return np.unique(np.sort(pairs[hit], axis=1), axis=0)


def _near_pairs(corners: np.ndarray) -> np.ndarray:
    """(K, 2) triangles whose bounding spheres touch, each pair once."""
    centres = corners.mean(1)
    radii = np.linalg.norm(corners - centres[:, None], axis=-1).max(1)
    # Half of the triangles are small and near to few others, which one query finds at once; the large ones look for
    # what is not larger than themselves.
    limit = np.median(radii)
    small = np.flatnonzero(radii <= limit)
    large = np.flatnonzero(radii > limit)
    pairs = [small[cKDTree(centres[small]).query_pairs(2 * limit, output_type="ndarray")]]
    if len(large):
        near = cKDTree(centres).query_ball_point(centres[large], 2 * radii[large], return_sorted=False)
        first = np.repeat(large, [len(ids) for ids in near])
        second = np.concatenate([np.asarray(ids, dtype=np.int64) for ids in near])
        smaller = (radii[second] < radii[first]) | ((radii[second] == radii[first]) & (second < first))
        pairs.append(np.stack([first, second], axis=1)[smaller])
    first, second = np.concatenate(pairs).T
    gaps = ((centres[first] - centres[second]) ** 2).sum(1)
    return np.stack([first, second], axis=1)[gaps <= (radii[first] + radii[second]) ** 2]


def _an_edge_pierces(triangles: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(K,) bool: whether an edge of triangles (K, 3, 3) goes through the inside of others (K, 3, 3)."""
    origin = others[:, 0]
    a = others[:, 1] - origin
    b = others[:, 2] - origin
    pierces = np.zeros(len(triangles), dtype=bool)
    for k in range(3):
        start = triangles[:, k]
        way = triangles[:, (k + 1) % 3] - start
        # Möller and Trumbore 1997.
        p = np.cross(way, b)
        determinant = (a * p).sum(1)
        parallel = np.abs(determinant) <= _PARALLEL * np.linalg.norm(a, axis=1) * np.linalg.norm(p, axis=1)
        inverse = 1 / np.where(parallel, np.inf, determinant)
        rest = start - origin
        u = (rest * p).sum(1) * inverse
        q = np.cross(rest, a)
        v = (way * q).sum(1) * inverse
        t = (b * q).sum(1) * inverse
        pierces |= ~parallel & (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
    return pierces
