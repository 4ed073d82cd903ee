"""Pixels inside a polygon."""

import cv2
import numpy as np


def inside_polygon(points: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """(H, W) bool: what points (K, 2), pixels, enclose in a picture of the shape (H, W)."""
    mask = np.zeros(shape, np.uint8)
    cv2.fillPoly(mask, [np.round(points).astype(np.int32)], 1)
    return mask > 0
