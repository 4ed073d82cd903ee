"""The outline of a head in a picture."""

import numpy as np

from caricli.render.visibility.rasterise import rasterise

_FINER = 4
"""Pixels of the mask to one of the canvas."""
_LARGEST = 1536
"""Pixels of the mask, at most."""
_SMOOTH = 0.004
"""Of the canvas: standard deviation of the smoothing that takes the steps of pixels off."""
_STEP = 0.012
"""Of the canvas: distance of the points."""


def head_outline(placed: np.ndarray, faces: np.ndarray, size: tuple[int, int]) -> np.ndarray | None:
    """The longest outer outline of a mesh.

    placed: (V, 3) pixels and depth, as `rasterise` takes them. faces: (F, 3). size: (width, height) of the canvas.
    Returns (N, 2) pixels, closed, the last point the first; or None where nothing is seen.
    """
    import cv2
    from scipy.ndimage import gaussian_filter1d

    longer = max(size)
    # The mask is of the mesh, not of the canvas, so that what leaves the canvas keeps its outline.
    used = placed[np.unique(faces), :2]
    low = used.min(0)
    extent = np.ptp(used, axis=0)
    zoom = min(_FINER, _LARGEST / max(float(extent.max()), 1e-6))
    shifted = (placed - [*low, 0]) * zoom + [2, 2, 0]
    width, height = (int(np.ceil(side * zoom)) + 5 for side in extent)
    mask = (rasterise(shifted, faces, width, height).face >= 0).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    ring = max(contours, key=len)[:, 0].astype(np.float64)
    ring = gaussian_filter1d(ring, max(_SMOOTH * longer * zoom, 0.5), axis=0, mode="wrap")
    points = (ring - 2) / zoom + low
    steps = max(round(len(points) / max(_STEP * longer * zoom, 1)), 8)
    points = points[np.linspace(0, len(points), steps, endpoint=False).astype(int)]
    return np.vstack([points, points[:1]])
