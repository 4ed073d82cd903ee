"""Values of pictures, from 0 to 1 or in bytes."""

import numpy as np


def to_bytes(image: np.ndarray) -> np.ndarray:
    """Values from 0 to 1 as uint8; what is beyond is cut off."""
    return np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)


def to_floats(levels: np.ndarray) -> np.ndarray:
    """The inverse of ``to_bytes``, float32."""
    return levels.astype(np.float32) / 255


def saturated(image: np.ndarray, amount: float) -> np.ndarray:
    """Colours (H, W, 3) from 0 to 1 farther from grey: 1 leaves them."""
    grey = image.mean(2, keepdims=True)
    return np.clip(grey + amount * (image - grey), 0, 1)
