"""The colours of the eyes in a picture."""

from operator import itemgetter

import cv2
import numpy as np

from caricli.render.eye_window import WIDTH, eye_windows
from caricli.render.inside_polygon import inside_polygon

_FEWEST = 12  # pixels between the lids: fewer say nothing about a colour
_WINDOW = 2.0  # side of what is looked at, in widths of the eye
_RADII = np.arange(0.12, 0.42, 0.02) * WIDTH  # of an iris
_LIDS = 0.1 * WIDTH  # pixels from the lids, nearer than which lashes and shadows make a pixel count less
_INSIDE, _OUTSIDE = 0.9, 1.1  # of an iris' radius: within is its colour, and beyond is the white's
_IRIS_SHADES = (0.4, 0.85)  # quantiles of brightness: pupil and reflections are the extremes of what is inside
_WHITE_SHADE = 0.7  # quantile of brightness: lashes and shadows of the lids are darker than the white


def eye_colours(image: np.ndarray, points: np.ndarray) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Colours of iris and white, from the pixels between the lids.

    The iris is the disc there that differs most from what is around it, and is darker. The more it differs, the more
    an eye counts: what hair covers differs little.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown.
    Returns two (3,) arrays, sRGB 0 to 255, or None for either that cannot be seen.
    """
    irises: list[tuple[np.ndarray, float]] = []
    whites: list[tuple[np.ndarray, float]] = []
    for window in eye_windows(image, points, _WINDOW):
        opening = inside_polygon(window.outline, window.picture.shape[:2])
        if opening.sum() < _FEWEST * window.zoom**2:
            continue
        contrast, middle, radius = _iris(window.picture, opening)
        rows, columns = np.nonzero(opening)
        colours = window.picture[rows, columns].astype(float)
        light = colours.mean(1)
        away = np.hypot(columns - middle[0], rows - middle[1]) / radius
        inside = away < _INSIDE
        outside = away > _OUTSIDE
        if inside.sum() >= _FEWEST:
            low, high = np.quantile(light[inside], _IRIS_SHADES)
            irises.append((np.median(colours[inside & (light >= low) & (light <= high)], axis=0), contrast))
        if outside.sum() >= _FEWEST:
            bright = light >= np.quantile(light[outside], _WHITE_SHADE)
            whites.append((np.median(colours[outside & bright], axis=0), contrast))
    return _mean(irises), _mean(whites)


def _iris(picture: np.ndarray, opening: np.ndarray) -> tuple[float, np.ndarray, float]:
    """The disc that parts the pixels between lids best, by their variance (Otsu 1979): their standard deviation between
    both parts, its middle (2,) and its radius.

    picture: (S, S, 3) uint8. opening: (S, S) bool. What counts of a colour is its least channel, of which skin has less
    than whites.
    """
    depth = cv2.distanceTransform(opening.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    counted = np.minimum(depth / _LIDS, 1).astype(np.float32)
    light = counted * picture.min(-1)
    best = (-1.0, np.zeros(2), 1.0)
    for radius in _RADII:
        reach = int(radius)
        disc = (np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) <= radius).astype(np.float32)
        inner, lit = (cv2.filter2D(each, -1, disc, borderType=cv2.BORDER_CONSTANT) for each in (counted, light))
        outer = counted.sum() - inner
        darker = (light.sum() - lit) / np.maximum(outer, 1e-3) - lit / np.maximum(inner, 1e-3)
        variance = np.where(opening, inner * outer * np.maximum(darker, 0) ** 2, -1)
        row, column = np.unravel_index(variance.argmax(), variance.shape)
        best = max(best, (float(variance[row, column]), np.array([column, row]), float(radius)), key=itemgetter(0))
    between, middle, radius = best
    return between**0.5 / float(counted.sum()), middle, radius


def _mean(colours: list[tuple[np.ndarray, float]]) -> np.ndarray | None:
    """The mean of colours (3,), each with its weight."""
    if not colours:
        return None
    values, weights = zip(*colours, strict=True)
    mean: np.ndarray = np.average(values, axis=0, weights=np.array(weights) + 1e-9)
    return mean
