"""Midpoint subdivision of polygon meshes."""

import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError


def subdivide(polygons: np.ndarray, count: int, levels: int, limit: int) -> tuple[sp.csr_matrix, np.ndarray]:
    """Split every polygon of n corners into n quads, some times over, without moving any point.

    Every edge and every polygon gets a point in its middle, the mean of its corners: the topology of Catmull and Clark.
    The quads stand in the order of the polygons and, in each, of the corners, whatever the indices are; so a table of
    UVs with seams of its own, subdivided as often, fits the polygons corner by corner.

    polygons: (P, N) int, unused trailing corners -1. count: of the points that they index, V. levels: how often.
    limit: of points, checked before anything large is allocated.
    Returns weights (W, V), sparse, that take what is known at the points to the new ones, its first V rows those of
    the identity; and the quads (Q, 4) int32, or at level 0 the polygons as they are.
    Raises InputError beyond the limit.
    """
    polygons = np.asarray(polygons, dtype=np.int32)
    _check_count(polygons, count, levels, limit)
    weights = sp.identity(count, format="csr")
    for _ in range(levels):
        step, polygons = _split(polygons, weights.shape[0])
        weights = step @ weights
    return weights, polygons


def _split(polygons: np.ndarray, count: int) -> tuple[sp.csr_matrix, np.ndarray]:
    """One level: weights (count + edges + polygons, count) and quads."""
    starts, owners, edges, after = _corners(polygons, count)
    sizes = (polygons >= 0).sum(1)
    centres = count + len(edges) + np.arange(len(polygons))
    at_edges = np.repeat(count + np.arange(len(edges)), 2)
    at_points = np.arange(count)
    rows = np.concatenate([at_points, at_edges, centres[owners]])
    columns = np.concatenate([at_points, edges.ravel(), starts])
    values = np.concatenate([np.ones(count), np.full(edges.size, 0.5), 1 / sizes[owners]])
    weights = sp.csr_matrix((values, (rows, columns)), shape=(count + len(edges) + len(polygons), count))
    # The edge before a corner is the one after the corner before it; before a polygon's first corner comes its last.
    first = np.cumsum(sizes) - sizes
    before = np.arange(len(starts)) - 1
    before[first] += sizes
    quads = np.stack([starts, count + after, centres[owners], count + after[before]], axis=1)
    return weights, quads.astype(np.int32)


def _corners(polygons: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points and polygons of all corners (C,), edges (E, 2), and the edge after every corner (C,)."""
    used = polygons >= 0
    following = np.roll(polygons, -1, axis=1)
    last = used & np.c_[~used[:, 1:], np.ones(len(polygons), dtype=bool)]
    following[last] = polygons[:, 0]
    starts = polygons[used].astype(np.int64)
    ends = following[used].astype(np.int64)
    keys, after = np.unique(np.minimum(starts, ends) * count + np.maximum(starts, ends), return_inverse=True)
    return starts, np.nonzero(used)[0], np.stack(np.divmod(keys, count), axis=1), after


def _check_count(polygons: np.ndarray, count: int, levels: int, limit: int) -> None:
    starts, _, pairs, _ = _corners(polygons, count)
    edges = len(pairs)
    faces = len(polygons)
    corners = len(starts)
    for _ in range(levels):
        count += edges + faces
        edges = 2 * edges + corners
        faces = corners
        corners *= 4
    if count > limit:
        raise InputError(f"subdivision beyond the memory cap: expected at most {limit} points, found {count}")
