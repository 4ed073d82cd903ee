"""A mask and what is around it."""

import cv2
import numpy as np


def widen_mask(mask: np.ndarray, pixels: int) -> np.ndarray:
    """(H, W) bool: a mask (H, W) bool and so many pixels around it, in a square."""
    wide: np.ndarray = cv2.dilate(mask.astype(np.uint8), np.ones((2 * pixels + 1,) * 2, np.uint8)) > 0
    return wide
