"""Masks of smaller pictures."""

import cv2
import numpy as np


def smaller_mask(mask: np.ndarray, zoom: float) -> np.ndarray:
    """A mask (H, W) bool in a picture so many times as large, less than one: pixels of which it has more than half."""
    shares = cv2.resize(mask.astype(np.float32), None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    return shares > 0.5
