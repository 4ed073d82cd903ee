"""A portrait before and after it was stylised."""

import numpy as np

from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.crop_portrait import crop_portrait
from caricli.render.sheets.overlay import draw_landmarks

MOVED = (255, 90, 60)

_SIDE = 480  # pixels
_DOT = 0.008  # of the landmarks' extent


def stylise_sheet(pictures: dict[str, np.ndarray], landmarks: np.ndarray) -> np.ndarray:
    """The faces of pictures of one size beside each other, the last one also with its landmarks.

    pictures: (H, W, 3) uint8 by their labels: as it was given, and on the way to what became of it. landmarks: (L, 2)
    pixels of the last one, NaN where unknown.
    Returns (H', W', 3) uint8.
    """
    last = list(pictures.values())[-1]
    radius = _DOT * float(np.nanmax(np.nanmax(landmarks, axis=0) - np.nanmin(landmarks, axis=0)))
    marked = draw_landmarks(last, landmarks, MOVED, radius)
    faces = [crop_portrait(picture, landmarks, _SIDE) for picture in (*pictures.values(), marked)]
    return contact_sheet(faces, len(faces), [*pictures, "landmarks"])
