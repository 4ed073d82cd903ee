"""The nearest pixel of a mask."""

import cv2
import numpy as np


def nearest_pixel(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row and column (H, W) of the pixel of a mask (H, W) bool that is nearest to each; of a few nearly as near, one.

    A pixel of the mask is nearest to itself. Raises ValueError when the mask is empty.
    """
    row, column = np.divmod(nearest_index(mask), mask.shape[1])
    return row, column


def nearest_index(mask: np.ndarray) -> np.ndarray:
    """(H, W) the same pixels by their places in the mask row by row; see ``nearest_pixel``."""
    if not mask.any():
        raise ValueError("an empty mask has no nearest pixel")
    beside = (~mask).astype(np.uint8)
    _, labels = cv2.distanceTransformWithLabels(beside, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    pixels = np.zeros(int(labels.max()) + 1, np.intp)
    pixels[labels[mask]] = np.flatnonzero(mask)
    return pixels.take(np.asarray(labels, np.intp))
