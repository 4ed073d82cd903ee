"""How far the pixels of a picture are from a part of it."""

import cv2
import numpy as np


def distance_to(mask: np.ndarray) -> np.ndarray:
    """(H, W) pixels to a mask (H, W) bool, to a few percent; 0 inside."""
    distance: np.ndarray = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    return distance


def exact_distance_to(mask: np.ndarray) -> np.ndarray:
    """As ``distance_to``, to the last digit."""
    distance: np.ndarray = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return distance
