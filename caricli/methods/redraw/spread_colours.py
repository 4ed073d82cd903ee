"""Values of some pixels carried on to all others."""

import cv2
import numpy as np

_SMALL = 1e-4


def spread_colours(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Fill what has no value with a mean of what is around it, the wider the farther off (push and pull).

    values: (H, W, C) float32. weights: (H, W) float32 from 0 to 1, how far pixels have a value.
    Returns (H, W, C), equal to the values where weights are one; zeros where there are none at all.
    """
    height, width = weights.shape
    mean = values * weights[..., None]
    if max(height, width) > 1:
        size = ((width + 1) // 2, (height + 1) // 2)
        share = cv2.resize(weights, size, interpolation=cv2.INTER_AREA)
        sums = cv2.resize(mean, size, interpolation=cv2.INTER_AREA).reshape(size[1], size[0], -1)
        coarse = spread_colours(sums / np.maximum(share, _SMALL)[..., None], np.minimum(4 * share, 1))
        wide = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR).reshape(values.shape)
        mean = mean + (1 - weights)[..., None] * wide
    return mean
