"""What painting with arrays of colours is made of."""

import numpy as np


def mix(first: np.ndarray, second: np.ndarray, share: np.ndarray | float) -> np.ndarray:
    """Colours (..., 3) that are the first at a share of 0 and the second at 1. share: (...) or a number."""
    return first + np.asarray(share)[..., None] * (second - first)
