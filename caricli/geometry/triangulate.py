"""Polygons to triangles."""

import numpy as np


def triangulate(polygons):
    """Split polygons into triangle fans around their first corner.

    polygons: (P, N) int, unused trailing corners -1.
    Returns (F, 3) int32, in the order of the polygons.
    """
    polygons = np.asarray(polygons)
    width = polygons.shape[1]
    fans = np.stack([polygons[:, [0, k, k + 1]] for k in range(1, width - 1)], axis=1)
    return np.ascontiguousarray(fans[fans[:, :, 2] >= 0], dtype=np.int32)
