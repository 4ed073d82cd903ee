"""A picture painted."""

from collections.abc import Callable

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.methods.stylise.canvas import Canvas
from caricli.methods.stylise.draw_ink import draw_ink
from caricli.methods.stylise.draw_pencil import draw_pencil
from caricli.methods.stylise.paint_flat import paint_flat
from caricli.methods.stylise.paint_oil import paint_oil
from caricli.methods.stylise.paint_watercolour import paint_watercolour
from caricli.render.pixels.levels import to_bytes, to_floats
from caricli.structures import Landmarks

LARGEST = 6.0
"""Unit in pixels up to which painters paint; pictures of larger faces are painted smaller and enlarged."""

SMALLEST = 2.2
"""The same from which on they do; pictures of smaller faces are painted larger, where they are not large themselves."""

_LARGER = 2_500_000
"""Pixels that a picture has at most when it is painted larger than it is."""

_MOST = 12_000_000
"""Pixels that are painted at most; larger pictures are enlarged afterwards."""

_NEAR = 0.25
_FAR = 0.9
"""Shares of the diagonal of the landmarks: how far around them painters take care, and from where on they do not."""

PAINTERS: dict[str, Callable[[Canvas], np.ndarray]] = {
    "oil": paint_oil,
    "watercolour": paint_watercolour,
    "ink": draw_ink,
    "flat": paint_flat,
    "pencil": draw_pencil,
}
"""By the STYLES that have one."""


def paint_picture(image: np.ndarray, marks: Landmarks, style: str, generator: np.random.Generator) -> np.ndarray:
    """Paint a picture; brushes, lines and grain are as large as its face tells.

    image: (H, W, 3) uint8. marks: Landmarks of the face. style: of STYLES; "none" leaves the picture. generator: of
    strokes and grain.
    Returns (H, W, 3) uint8. Raises InputError for another style.
    """
    if style == "none":
        return image
    if style not in PAINTERS:
        raise InputError(f"expected a style of {', '.join(PAINTERS)} or none, found {style}")
    height, width = image.shape[:2]
    unit = marks.diagonal / 100
    larger, most = ((count / (width * height)) ** 0.5 for count in (_LARGER, _MOST))
    scale = min(max(1.0, min(SMALLEST / unit, larger)), LARGEST / unit, most)
    size = [max(1, round(length * scale)) for length in (width, height)]
    points = marks.points[marks.known] * scale
    care = _care(points, size, marks.diagonal * scale)
    canvas = Canvas(to_floats(_sized(image, size)), unit * scale, care, generator)
    return _sized(to_bytes(PAINTERS[style](canvas)), [width, height])


def _sized(image: np.ndarray, size: list[int]) -> np.ndarray:
    """A picture (H, W, 3) uint8 in another size, width and height."""
    if list(image.shape[1::-1]) == size:
        return image
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if size[0] < image.shape[1] else cv2.INTER_CUBIC)


def _care(points: np.ndarray, size: list[int], diagonal: float) -> np.ndarray:
    """(H, W) float32, 1 near points (N, 2), 0 far from them."""
    away = np.ones(size[::-1], np.uint8)
    hull = cv2.convexHull(np.rint(points).astype(np.int32))
    cv2.fillConvexPoly(away, hull, 0)
    distance = cv2.distanceTransform(away, cv2.DIST_L2, 5) / diagonal if (away == 0).any() else np.full(size[::-1], 9.0)
    return np.clip((_FAR - distance) / (_FAR - _NEAR), 0, 1).astype(np.float32)
