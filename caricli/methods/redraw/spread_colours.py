"""Values of some pixels carried on to all others."""

import cv2
import numpy as np

_SMALL = 1e-4
_AROUND = 0.5  # of a box's longer side, what is looked at on each side of it


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


def box_around(mask: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns within which ``spread_colours`` finds what fills a mask (H, W); of an empty one the first."""
    rows = np.flatnonzero(mask.any(1))
    if not len(rows):
        return slice(0, 1), slice(0, 1)
    columns = np.flatnonzero(mask.any(0))
    margin = int(_AROUND * max(np.ptp(rows), np.ptp(columns))) + 1
    top, left = max(rows[0] - margin, 0), max(columns[0] - margin, 0)
    return slice(top, rows[-1] + margin + 1), slice(left, columns[-1] + margin + 1)
