"""The points that a line was drawn through."""

from functools import lru_cache

import numpy as np

_CLEAR = 0.3
"""Nodes are found where pieces between them leave less than this share of what pieces around them leave."""
_ROUNDING = 1e-9
"""Of a line's extent: what is left of it is none."""
_FREE = 4
"""Points of a line beyond the numbers of its pieces, at least: with fewer, pieces fit anywhere."""
_MOST = 1024
"""Points of a line whose nodes are looked for."""


def line_nodes(line: np.ndarray, count: int) -> np.ndarray | None:
    """Numbers (count,) of the points, between them fractions, that a line was drawn through.

    Drawing programs put a curve or a straight line between any two points that somebody set, and files show it as
    equally many points in every piece. So, where pieces from node to node (cubic with a common slope, or straight),
    fitted by least squares, leave much less than pieces from the middle of one to the middle of the next, nodes are
    there. Lines that a hand drew show none, and neither do ones with points at equal distances.

    line: (N, 2). count: of the nodes, at least three, the ends among them.
    Returns None where there are none.
    """
    points = len(line)
    if points == count:
        return np.arange(count, dtype=float)
    if not count < points <= _MOST:
        return None
    centred = line - line.mean(0)
    for smooth in (True, False):
        left = [_left(centred, count, around, smooth) for around in (False, True)]
        if left[0] < _CLEAR * left[1] and left[1] > _ROUNDING * np.abs(centred).max():
            return np.linspace(0, points - 1, count)
    return None


def _left(line: np.ndarray, count: int, around: bool, smooth: bool) -> float:
    """Root mean square of what pieces leave of a line (N, 2), per number that they are free of; 0 where they fit any.

    around: from middle to middle instead of from node to node. smooth: cubic, not straight.
    """
    basis = _basis(len(line), count, around, smooth)
    free = len(line) - basis.shape[1]
    if free < _FREE:
        return 0.0 if around else np.inf
    return float(np.sqrt(((line - basis @ (basis.T @ line)) ** 2).sum() / free))


@lru_cache(maxsize=256)
def _basis(points: int, count: int, around: bool, smooth: bool) -> np.ndarray:
    """Orthonormal columns (N, D) that span what pieces can be at N places from the first node to the last."""
    nodes = np.arange(count, dtype=float)
    knots = np.concatenate([nodes[:1], nodes[:-1] + 0.5, nodes[-1:]]) if around else nodes
    places = np.linspace(0, count - 1, points)
    piece = np.clip(np.searchsorted(knots, places, "right") - 1, 0, len(knots) - 2)
    step = knots[piece + 1] - knots[piece]
    t = (places - knots[piece]) / step
    rows = np.arange(points)
    table = np.zeros((points, 2 * len(knots)))
    if smooth:
        ends = 1 + t * t * (2 * t - 3), t * t * (3 - 2 * t)
        slopes = step * t * (1 - t) ** 2, step * t * t * (t - 1)
        table[rows, len(knots) + piece] = slopes[0]
        table[rows, len(knots) + piece + 1] = slopes[1]
    else:
        ends = 1 - t, t
    table[rows, piece] = ends[0]
    table[rows, piece + 1] = ends[1]
    basis, sizes, _ = np.linalg.svd(table, full_matrices=False)
    return basis[:, sizes > 1e-9 * sizes[0]]
