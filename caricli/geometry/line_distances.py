"""How far points lie from lines."""

from collections.abc import Sequence

import numpy as np


def line_distances(points: np.ndarray, lines: Sequence[np.ndarray]) -> np.ndarray:
    """Distances of points to the nearest of some lines.

    points: (N, 2). lines: arrays (M, 2), of at least one point each, not empty.
    Returns (N,).
    """
    best = np.full(len(points), np.inf)
    for line in lines:
        starts = line[:-1] if len(line) > 1 else line
        along = np.diff(line, axis=0) if len(line) > 1 else np.zeros_like(line)
        squares = np.maximum((along**2).sum(1), 1e-300)
        gaps = points[:, None] - starts
        shares = np.clip((gaps * along).sum(-1) / squares, 0, 1)
        best = np.minimum(best, np.linalg.norm(gaps - shares[..., None] * along, axis=-1).min(1))
    return best
