"""Polygons of a net around a pole."""

import numpy as np


def polar_quads(rows: int, columns: int) -> np.ndarray:
    """A fan of triangles around the first vertex, and rings of quads after it.

    rows: R rings of vertices around the first one, which is the pole. columns: C vertices of a ring; ring by ring they
    come after the pole. Returns (R C, 4) int32, the fan first, its rows ending with -1.
    """
    rings = 1 + np.arange(rows * columns).reshape(rows, columns)
    after = np.roll(rings, -1, axis=1)
    fan = np.column_stack([np.zeros(columns, int), rings[0], after[0], np.full(columns, -1)])
    between = [np.column_stack([rings[k], rings[k + 1], after[k + 1], after[k]]) for k in range(rows - 1)]
    return np.concatenate([fan, *between]).astype(np.int32)
