"""A stroke as a small picture, wherever and however large it was drawn."""

import cv2
import numpy as np

_BITS = 5  # of the fraction of a pixel
_THICK = 1 / 32
"""Width of the pen, of the side of the picture."""
_MARGIN = 1 / 16
"""What stays free on every side."""


def draw_stroke(points: np.ndarray, size: int) -> np.ndarray:
    """Draw a stroke so that its longer side fills the picture.

    points: (N, 2) pixels, y down, not all in one place. size: of the picture, pixels.
    Returns ink (S, S) uint8.
    """
    low = points.min(0)
    extent = points.max(0) - low
    scale = (1 - 2 * _MARGIN) * (size - 1) / float(extent.max())
    placed = (points - low - extent / 2) * scale + (size - 1) / 2
    ink = np.zeros((size, size), np.uint8)
    fixed = np.rint(placed * (1 << _BITS)).astype(np.int32)
    cv2.polylines(ink, [fixed], False, 255, max(round(_THICK * size), 1), cv2.LINE_AA, _BITS)
    return ink
