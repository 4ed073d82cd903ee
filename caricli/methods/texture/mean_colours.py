"""What colours a part of a picture has around each of its pixels."""

import cv2
import numpy as np

_SMALL = 6  # pixels, standard deviation of the means, which a larger one is scaled down to
_SMALLEST = 0.5  # pixels: with less of a standard deviation no pixel hears of the next
_FAINT = 1e-3  # share of such pixels around, with less of them there are none


def mean_colours(image: np.ndarray, mask: np.ndarray, reach: float) -> np.ndarray:
    """Means of the colours of a part of a picture around each pixel.

    image: (H, W, 3) uint8. mask: (H, W) bool. reach: pixels, standard deviation of a Gaussian, at least half a pixel.
    Returns (H, W, 3) CIELAB, NaN where there is none of it around.
    """
    reach = max(reach, _SMALLEST)
    size = np.array(mask.shape[::-1])
    small = np.maximum(np.round(min(1.0, _SMALL / reach) * size), 1).astype(int)
    spread = reach * small / size
    shares, colours = (
        cv2.resize(each.astype(np.float32), small.tolist(), interpolation=cv2.INTER_AREA)
        for each in (mask, cv2.copyTo(image, mask.astype(np.uint8)))
    )
    # Of a pixel that is partly in the mask only that part counts: no colour comes in from beside it.
    own = cv2.cvtColor(colours / (255 * np.where(shares > 0, shares, 1)[..., None]), cv2.COLOR_RGB2LAB)
    sums = cv2.GaussianBlur(own * shares[..., None], (0, 0), *spread)
    shares = cv2.GaussianBlur(shares, (0, 0), *spread)
    means = sums / np.where(shares > _FAINT, shares, np.nan)[..., None]
    return cv2.resize(means, size.tolist(), interpolation=cv2.INTER_LINEAR)
