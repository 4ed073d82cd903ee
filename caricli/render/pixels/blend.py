"""Pictures with alpha over pictures without."""

from collections.abc import Sequence

import numpy as np


def over(image: np.ndarray, background: np.ndarray | Sequence[float], opacity: float = 1.0) -> np.ndarray:
    """Lay a picture over a background.

    image: (H, W, 3 or 4) uint8, alpha not premultiplied. background: (H, W, 3) uint8, or one colour (3,), 0 to 255.
    opacity: 0 to 1, for the whole picture.
    Returns (H, W, 3) uint8.
    """
    alpha = image[..., 3:] / 255 if image.shape[2] == 4 else np.ones((*image.shape[:2], 1))
    alpha = opacity * alpha
    return np.rint(image[..., :3] * alpha + np.asarray(background, float) * (1 - alpha)).astype(np.uint8)
