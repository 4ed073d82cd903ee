"""Triangles of one mesh that go through each other."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import KDTree

from caricli.errors import NumericsError
from caricli.geometry.places_of import places_of

MAX_PAIRS = 20_000_000
"""Triangles near to each other that are looked at, in half a minute; a head has 15 for every triangle."""

_BLOCK = 2**18  # pairs looked at at once, in about 150 MB
_PARALLEL = 1e-12  # sine of the angle between an edge and a plane: with less they do not meet


def self_intersections(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Find pairs of triangles without a corner in one place, an edge of one of which goes through the other.

    vertices: (V, 3). faces: (F, 3).
    Returns (K, 2) triangle numbers, the smaller first, in order. Raises NumericsError where more than MAX_PAIRS are
    near to each other, as in a mesh whose vertices lie in one place.
    """
    corners = vertices[faces]
    places = places_of(vertices)[faces]
    crossing = [_crossing(pairs, corners, places) for pairs in _near_pairs(corners)]
    return np.unique(np.sort(np.concatenate(crossing), axis=1), axis=0)


def _crossing(pairs: np.ndarray, corners: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Those of pairs (K, 2) of triangles that go through each other. corners: (F, 3, 3) of the triangles. places: (F,
    3) the numbers of these."""
    low, high = corners.min(1), corners.max(1)
    first, second = pairs.T
    overlap = ((low[first] <= high[second]) & (low[second] <= high[first])).all(1)
    pairs = pairs[overlap]
    first, second = pairs.T
    apart = (places[first][:, :, None] != places[second][:, None]).all((1, 2))
    pairs = pairs[apart]
    triangles = corners[pairs[:, 0]]
    others = corners[pairs[:, 1]]
    return pairs[_an_edge_pierces(triangles, others) | _an_edge_pierces(others, triangles)]


def _near_pairs(corners: np.ndarray) -> Iterator[np.ndarray]:
    """Blocks (K, 2) of the triangles whose bounding spheres touch, each pair once."""
    centres = corners.mean(1)
    radii = np.linalg.norm(corners - centres[:, None], axis=-1).max(1)
    # Half of the triangles are small and near to few others, which one query finds at once; the large ones look for
    # what is not larger than themselves.
    limit = np.median(radii)
    small = np.flatnonzero(radii <= limit)
    large = np.flatnonzero(radii > limit)
    among_small = KDTree(centres[small])
    among_all = KDTree(centres)
    counts = among_all.query_ball_point(centres[large], 2 * radii[large], return_length=True).astype(np.int64)
    # Counting takes no memory, listing them may take all of it. Of the small ones each counts itself, and each other.
    near = (among_small.count_neighbors(among_small, 2 * limit) - len(small)) // 2 + int(counts.sum())
    if near > MAX_PAIRS:
        raise NumericsError(f"expected a surface, found {near} pairs of triangles in one place")
    pairs = small[among_small.query_pairs(2 * limit, output_type="ndarray")]
    for start in range(0, len(pairs), _BLOCK):
        yield _touching(pairs[start : start + _BLOCK], centres, radii)
    for rows in np.split(np.arange(len(large)), np.flatnonzero(np.diff(np.cumsum(counts) // _BLOCK)) + 1):
        lists = among_all.query_ball_point(centres[large[rows]], 2 * radii[large[rows]], return_sorted=False)
        first = np.repeat(large[rows], counts[rows])
        second = np.concatenate([np.asarray(ids, dtype=np.int64) for ids in [[], *lists]])
        smaller = (radii[second] < radii[first]) | ((radii[second] == radii[first]) & (second < first))
        yield _touching(np.stack([first, second], axis=1)[smaller], centres, radii)


def _touching(pairs: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Those of pairs (K, 2) whose bounding spheres touch."""
    first, second = pairs.T
    gaps = ((centres[first] - centres[second]) ** 2).sum(1)
    return pairs[gaps <= (radii[first] + radii[second]) ** 2]


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
