"""What colours a part of a picture has around each of its pixels."""

import cv2
import numpy as np

_SMALL = 6  # pixels, standard deviation of the means, which a larger one is scaled down to
_FAINT = 1e-3  # share of such pixels around, with less of them there are none


def mean_colours(image: np.ndarray, mask: np.ndarray, reach: float) -> np.ndarray:
    """Means of the colours of a part of a picture around each pixel.

    image: (H, W, 3) uint8. mask: (H, W) bool. reach: pixels, standard deviation of a Gaussian.
    Returns (H, W, 3) CIELAB, NaN where there is none of it around.
    """
    zoom = min(1.0, _SMALL / reach)
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    shares = cv2.resize(mask.astype(np.float32), small.shape[1::-1], interpolation=cv2.INTER_AREA)
    sums = cv2.GaussianBlur(cv2.cvtColor(small, cv2.COLOR_RGB2LAB) * shares[..., None], (0, 0), _SMALL)
    shares = cv2.GaussianBlur(shares, (0, 0), _SMALL)
    means = sums / np.where(shares > _FAINT, shares, np.nan)[..., None]
    return cv2.resize(means, mask.shape[::-1], interpolation=cv2.INTER_LINEAR)
