"""Pictures with alpha over pictures without."""

import numpy as np


def over(image, background, opacity=1.0):
    """Lay a picture over a background.

    image: (H, W, 3 or 4) uint8, alpha not premultiplied. background: (H, W, 3) uint8, or one colour (3,), 0 to 255.
    opacity: 0 to 1, for the whole picture.
    Returns (H, W, 3) uint8.
    """
    alpha = image[..., 3:] / 255 if image.shape[2] == 4 else np.ones((*image.shape[:2], 1))
    alpha = opacity * alpha
    return np.rint(image[..., :3] * alpha + np.asarray(background, float) * (1 - alpha)).astype(np.uint8)
