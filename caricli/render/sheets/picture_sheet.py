"""Pictures with truth, beside what is known of them."""

from collections.abc import Iterable

import cv2
import numpy as np

from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.structures.parsing import REGION_COLOURS

SEEN = (40, 220, 60)
HIDDEN = (230, 40, 40)
"""sRGB of landmarks that are visible and of those that are not."""

_SHARE = 0.65  # of the picture that a label map covers


def picture_sheet(rows: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]) -> np.ndarray:
    """Pictures, each beside itself under its label map and landmarks.

    rows: picture (H, W, 3) uint8, Regions (H, W) uint8, landmarks (N, 2) pixels of all its faces, and which (N,) of
    these are visible. Returns (H, W, 3) uint8. Raises InputError when there is no picture.
    """
    return contact_sheet([np.hstack([image, explained(image, *truth)]) for image, *truth in rows])


def explained(image: np.ndarray, regions: np.ndarray, points: np.ndarray, visible: np.ndarray) -> np.ndarray:
    """A picture (H, W, 3) uint8 under a label map (H, W) and landmarks (N, 2)."""
    colours = np.array(REGION_COLOURS, float)[regions]
    drawn = np.round(image + _SHARE * (regions > 0)[..., None] * (colours - image)).astype(np.uint8)
    radius = max(1, image.shape[1] // 200)
    for (x, y), seen in zip(points, visible, strict=True):
        place = (round(float(x)), round(float(y)))
        cv2.circle(drawn, place, radius, SEEN if seen else HIDDEN, -1, cv2.LINE_AA)
    return drawn
