"""How far along a line its points are."""

import numpy as np


def arc_lengths(line: np.ndarray) -> np.ndarray:
    """(N,) of the length of a line from its first point, 0, up to each of its points (N, D)."""
    return np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
