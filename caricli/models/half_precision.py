"""Networks in half precision, as files hold them."""

from collections.abc import Mapping

import numpy as np


def in_half_precision(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays by name: weights in half precision, statistics of normalisation and other columns in single."""
    return {name: value.astype(np.float16 if value.ndim > 1 else np.float32) for name, value in arrays.items()}
