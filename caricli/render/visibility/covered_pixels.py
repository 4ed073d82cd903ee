"""Which pixels of a picture a mesh covers, without asking by which of its triangles."""

import numpy as np

from caricli.render.visibility.rasterise import mesh_arrays

_BLOCK = 1_000_000
"""Rows of triangles at a time: large pictures of many triangles would need much memory."""


def covered_pixels(vertices: np.ndarray, faces: np.ndarray, width: int, height: int) -> np.ndarray:
    """Pixels whose centre is in a triangle, or on its border.

    vertices: (V, 3) pixels, x right, y down; the centre of the top-left pixel is (0, 0). faces: (F, 3), seen from both
    sides. width, height: pixels.
    Returns (height, width) bool, what `rasterise` meets. Raises InputError when a coordinate is not finite or an index
    is out of range.
    """
    points, triangles = mesh_arrays(vertices, faces)
    corners = points[triangles, :2].astype(float)
    first = np.clip(np.ceil(corners[..., 1].min(1)), 0, height).astype(int)
    last = np.clip(np.floor(corners[..., 1].max(1)), -1, height - 1).astype(int)
    rows = np.maximum(last - first + 1, 0)
    # What begins and ends in every row of pixels, which cuts a triangle in one span; one place more than pixels.
    changes = np.zeros(height * (width + 1), np.int64)
    for block in np.split(np.arange(len(rows)), np.flatnonzero(np.diff(np.cumsum(rows) // _BLOCK)) + 1):
        owner = np.repeat(block, rows[block])
        row = first[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(rows[block]) - rows[block], rows[block])
        left, right = _spans(corners[owner], row)
        start = np.clip(np.ceil(left), 0, width).astype(int)
        end = np.maximum(np.clip(np.floor(right) + 1, 0, width).astype(int), start)
        for places, change in ((start, 1), (end, -1)):
            changes += change * np.bincount(row * (width + 1) + places, minlength=len(changes))
    return changes.reshape(height, width + 1).cumsum(1)[:, :width] > 0


def _spans(corners: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From where to where rows (N,) of pixels, each between its ends, are in triangles (N, 3, 2)."""
    left = np.full(len(row), np.inf)
    right = np.full(len(row), -np.inf)
    for k in range(3):
        x, y = corners[:, k].T
        other_x, other_y = corners[:, k - 1].T
        crosses = (np.minimum(y, other_y) <= row) & (row <= np.maximum(y, other_y))
        share = np.divide(row - y, other_y - y, out=np.zeros(len(row)), where=other_y != y)
        at = x + share * (other_x - x)
        left[crosses] = np.minimum(left, at)[crosses]
        right[crosses] = np.maximum(right, at)[crosses]
    return left, right
