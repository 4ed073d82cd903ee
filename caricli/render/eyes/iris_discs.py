"""Irises of a picture: discs between lids that differ from what is around them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from caricli.render.eyes.eye_window import WIDTH, EyeWindow, eye_windows
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.inside_polygon import inside_polygon

FEWEST = 12
"""Pixels between the lids: fewer say nothing."""

_WINDOW = 2.0  # side of what is looked at, in widths of the eye
_LIDS = 0.1 * WIDTH  # pixels from the lids, nearer than which lashes and shadows make a pixel count less


@dataclass(frozen=True, eq=False)
class OpenEye:
    """An eye whose lids are apart. window: EyeWindow. opening: (S, S) bool, what is between them."""

    window: EyeWindow
    opening: np.ndarray


@dataclass(frozen=True, eq=False)
class IrisDiscs:
    """Of R radii the disc that parts the pixels between lids best (Otsu 1979).

    variances: (R,) between both parts. middles: (R, 2) pixels. whole: variance of all those pixels.
    """

    variances: np.ndarray
    middles: np.ndarray
    whole: float


def open_eyes(image: np.ndarray, points: np.ndarray) -> Iterator[OpenEye]:
    """The eyes of a picture (H, W, 3) uint8 that are open. points: (L, 2) landmarks, pixels, NaN where unknown."""
    for window in eye_windows(image, points, _WINDOW):
        opening = inside_polygon(window.outline, window.picture.shape[:2])
        if opening.sum() >= FEWEST * window.zoom**2:
            yield OpenEye(window, opening)


def iris_discs(eye: OpenEye, radii: Sequence[float] | np.ndarray) -> IrisDiscs:
    """IrisDiscs of an eye that are darker than the rest. radii: (R,) pixels of its window.

    What counts of a colour is its least channel, of which skin has less than whites.
    """
    opening = eye.opening
    depth = exact_distance_to(~opening)
    counted = np.minimum(depth / _LIDS, 1).astype(np.float32)
    least = eye.window.picture.min(-1)
    light = counted * least
    count = float(counted.sum())
    mean = float(light.sum()) / count
    variances = []
    middles = []
    for radius in radii:
        reach = int(radius)
        disc = (np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) <= radius).astype(np.float32)
        inner, lit = (cv2.filter2D(each, -1, disc, borderType=cv2.BORDER_CONSTANT) for each in (counted, light))
        outer = count - inner
        darker = (light.sum() - lit) / np.maximum(outer, 1e-3) - lit / np.maximum(inner, 1e-3)
        variance = np.where(opening, inner * outer * np.maximum(darker, 0) ** 2, -1) / count**2
        row, column = np.unravel_index(variance.argmax(), variance.shape)
        variances.append(variance[row, column])
        middles.append((column, row))
    whole = float((counted * (least - mean) ** 2).sum()) / count
    return IrisDiscs(np.array(variances), np.array(middles), whole)
