"""The face of a picture, cut out by its landmarks."""

import numpy as np

from caricli.render.pixels.cut_square import cut_square

_HALF = 0.8
"""Half the side of the square, of the larger extent of the landmarks: with all of the head around them."""


def crop_portrait(picture: np.ndarray, points: np.ndarray, size: int) -> np.ndarray:
    """The square around landmarks.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, NaN where unknown. size: pixels, side of the result.
    Returns (size, size, 3) uint8, paper beyond the picture.
    """
    low = np.nanmin(points, axis=0)
    high = np.nanmax(points, axis=0)
    # Landmarks count from the middle of the first pixel, boxes from its corner.
    middle = (low + high) / 2 + 0.5
    half = _HALF * (high - low).max()
    return cut_square(picture, middle - half, 2 * half, size)
