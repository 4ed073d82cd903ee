"""How far points lie from lines."""

from collections.abc import Sequence

import numpy as np

_PIECES = 256
"""Of a line, that are looked at together, so that a long one does not fill the memory."""
_POINTS = 4096
"""That are looked at together."""


def line_distances(points: np.ndarray, lines: Sequence[np.ndarray]) -> np.ndarray:
    """Distances of points to the nearest of some lines.

    points: (N, 2). lines: arrays (M, 2), of at least one point each, not empty.
    Returns (N,).
    """
    best = np.full(len(points), np.inf)
    for line in lines:
        for first in range(0, len(points), _POINTS):
            block = slice(first, first + _POINTS)
            best[block] = np.minimum(best[block], _to_line(points[block], line))
    return best


def _to_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    best = np.full(len(points), np.inf)
    starts = line[:-1] if len(line) > 1 else line
    along = np.diff(line, axis=0) if len(line) > 1 else np.zeros_like(line)
    squares = np.maximum((along**2).sum(1), 1e-300)
    for first in range(0, len(starts), _PIECES):
        piece = slice(first, first + _PIECES)
        gaps = points[:, None] - starts[piece]
        shares = np.clip((gaps * along[piece]).sum(-1) / squares[piece], 0, 1)
        best = np.minimum(best, np.linalg.norm(gaps - shares[..., None] * along[piece], axis=-1).min(1))
    return best
