"""Steps by which a rough mask is brought to the border that colours have."""

import cv2
import numpy as np

from caricli.render.pixels.distance_to import distance_to


def depth_inside(mask: np.ndarray) -> np.ndarray:
    """(H, W) pixels to the border of a mask (H, W) bool, below zero beyond it."""
    return distance_to(~mask) - distance_to(mask)


def agreeing_chances(picture: np.ndarray, odds: np.ndarray, radius: int, alike: float) -> np.ndarray:
    """(H, W) float32 chances of which neighbours agree that look alike, by a guided filter (He et al. 2013).

    picture: (H, W, 3) uint8. odds: (H, W) natural logarithms. radius: pixels. alike: share of full scale by which
    neighbours may differ. A filter can leave the range from 0 to 1 a little.
    """
    chances = (1 / (1 + np.exp(-np.clip(odds, -30, 30)))).astype(np.float32)
    filtered: np.ndarray = cv2.ximgproc.guidedFilter(picture, chances, radius, (255 * alike) ** 2)
    return filtered
