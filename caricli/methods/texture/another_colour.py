"""Pixels whose colour is not that of what they seem to be part of, but of something else."""

import cv2
import numpy as np

_UNLIKE = 12.0  # in CIELAB: what is no farther from the colours around it is of their kind

LIKE = 0.5
"""Of the distance to these, what one to others is at most where nothing else is asked."""


def of_another_colour(
    image: np.ndarray, pixels: np.ndarray, around: np.ndarray, other: np.ndarray, like: float = LIKE
) -> np.ndarray:
    """(H, W) bool: which of some pixels are unlike the colours around them, and near to others.

    image: (H, W, 3) uint8. pixels: (H, W) bool, at least one. around: (H, W, 3) CIELAB; where it is NaN, nothing is
    told. other: CIELAB, (H, W, 3) or one colour (3,). like: of the distance to the colours around, what that to the
    others is at most; above 1, what is mixed of both counts, too.
    """
    own = lab_colours(image, pixels)
    unlike = np.linalg.norm(own - around[pixels], axis=1)
    away = np.linalg.norm(own - (other[pixels] if other.ndim > 1 else other), axis=1)
    another = np.zeros_like(pixels)
    another[pixels] = (unlike > _UNLIKE) & (away < like * unlike)
    return another


def lab_colours(image: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """(N, 3) CIELAB of the N pixels (H, W) bool of a picture (H, W, 3) uint8."""
    colours: np.ndarray = cv2.cvtColor(image[pixels][None].astype(np.float32) / 255, cv2.COLOR_RGB2LAB)[0]
    return colours
