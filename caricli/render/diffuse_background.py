"""Colours of a face carried on into what is behind it (portrait paper, section 3.2.3)."""

import cv2
import numpy as np

from caricli.render.nearest_pixel import nearest_pixel

LAYERS = 48
"""Pixels from the border of the face on which the mean goes on."""

_KERNEL = np.ones((3, 3), np.float32)


def diffuse_background(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Replace the background, layer by layer from the border of the face, with the mean of what was replaced before.

    A breadth-first search over the eight neighbours; beyond ``LAYERS`` pixels the nearest colour goes on.

    image: (H, W, 3) uint8. mask: (H, W) bool, the face.
    Returns (H, W, 3) uint8, equal to the image inside the mask.
    """
    if not mask.any():
        return image.copy()
    filled = mask.astype(np.float32)
    colours = image.astype(np.float32) * mask[..., None]
    for _ in range(LAYERS):
        weight = cv2.filter2D(filled, -1, _KERNEL, borderType=cv2.BORDER_CONSTANT)
        fresh = (filled == 0) & (weight > 0)
        if not fresh.any():
            break
        total = cv2.filter2D(colours, -1, _KERNEL, borderType=cv2.BORDER_CONSTANT)
        colours[fresh] = total[fresh] / weight[fresh][:, None]
        filled[fresh] = 1.0
    diffused = np.round(colours).astype(np.uint8)[nearest_pixel(filled > 0)]
    diffused[mask] = image[mask]
    return diffused
