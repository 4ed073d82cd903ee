"""Colours of a face carried on into what is behind it (portrait paper, section 3.2.3)."""

import cv2
import numpy as np

from caricli.render.visibility.nearest_pixel import nearest_index

LAYERS = 48
"""Pixels from the border of the face on which the mean goes on."""

_KERNEL = np.ones((3, 3), np.uint8)


def diffuse_background(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Replace the background, layer by layer from the border of the face, with the mean of what was replaced before.

    A breadth-first search over the eight neighbours; beyond ``LAYERS`` pixels the nearest colour goes on.

    image: (H, W, 3) uint8. mask: (H, W) bool, the face.
    Returns (H, W, 3) uint8, equal to the image inside the mask.
    """
    if not mask.any():
        return image.copy()
    # With an empty border, so that every pixel has eight neighbours; pixels by their number, of which layers are few.
    filled = np.pad(mask, 1).astype(np.uint8)
    kept = cv2.copyTo(image, mask.astype(np.uint8))
    colours = cv2.copyMakeBorder(kept, 1, 1, 1, 1, cv2.BORDER_CONSTANT).astype(np.float32)
    inside = np.pad(np.ones_like(mask), 1).ravel()
    flat = colours.reshape(-1, 3)
    width = filled.shape[1]
    around = np.array([row * width + column for row in (-1, 0, 1) for column in (-1, 0, 1)])
    for _ in range(LAYERS):
        grown = cv2.dilate(filled, _KERNEL)
        fresh = np.flatnonzero((grown > filled).ravel() & inside)
        if not len(fresh):
            break
        beside = fresh[:, None] + around
        weight = filled.ravel()[beside].sum(1, dtype=np.float32)
        flat[fresh] = sum(flat[each] for each in beside.T) / weight[:, None]
        filled.ravel()[fresh] = 1
    rounded = np.rint(colours[1:-1, 1:-1]).astype(np.uint8)
    return rounded.reshape(-1, 3).take(nearest_index(filled[1:-1, 1:-1] > 0), 0)
