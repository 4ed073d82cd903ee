"""Rows between rows."""

import numpy as np


def rows_at(wanted: np.ndarray, places: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (K, D) at wanted places (K,), linearly between rows (N, D) that stand at increasing places (N,); before the
    first and after the last they are those."""
    return np.stack([np.interp(wanted, places, column) for column in rows.T], axis=1)
