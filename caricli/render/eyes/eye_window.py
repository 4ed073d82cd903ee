"""An eye of a picture by itself."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from caricli.render.pixels.cut_window import cut_window
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT

WIDTH = 64
"""Pixels, of every eye."""


@dataclass(frozen=True, eq=False)
class EyeWindow:
    """An eye in the middle of a picture (S, S, 3) uint8. outline: (6, 2) pixels in it, landmarks of its lids. zoom: how
    many times as wide it is as in the picture that it is from."""

    picture: np.ndarray
    outline: np.ndarray
    zoom: float


def eye_windows(image: np.ndarray, points: np.ndarray, side: float) -> Iterator[EyeWindow]:
    """The eyes of a face, as far as they are known and in the picture, the subject's right one first.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown. side: of a window, in an eye's
    widths.
    """
    pixels = round(side * WIDTH)
    for eye in (EYE_RIGHT, EYE_LEFT):
        outline = points[list(eye)]
        # Of its corners, so that a tilted face has the same eyes.
        width = float(np.linalg.norm(outline[3] - outline[0]))
        middle = outline.mean(0)
        if not (width > 1 and (middle >= 0).all() and (middle < image.shape[1::-1]).all()):
            continue
        zoom = WIDTH / width
        shift = pixels / 2 - zoom * middle
        picture = cut_window(image, np.column_stack([zoom * np.eye(2), shift]), (pixels, pixels))
        yield EyeWindow(picture, zoom * outline + shift, zoom)
