"""Points of polylines by their share of the length."""

import numpy as np


def along(lines: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Points (B, P, D) at shares (B, P) of the length of polylines (B, N, D), at least two points each.

    Below 0 and above 1 the first and the last piece go on.
    """
    pieces = np.linalg.norm(np.diff(lines, axis=1), axis=2)
    reached = np.cumsum(np.concatenate([np.zeros((len(lines), 1)), pieces], 1), 1)
    asked = shares * reached[:, -1:]
    piece = np.clip((reached[:, None, 1:-1] <= asked[:, :, None]).sum(2), 0, pieces.shape[1] - 1)
    rows = np.arange(len(lines))[:, None]
    part = (asked - reached[rows, piece]) / np.maximum(pieces[rows, piece], 1e-12)
    first = lines[rows, piece]
    return first + part[..., None] * (lines[rows, piece + 1] - first)
