"""The colours of the eyes in a picture."""

import numpy as np

from caricli.render.eyes.eye_window import WIDTH
from caricli.render.eyes.iris_discs import FEWEST, iris_discs, open_eyes

_RADII = np.arange(0.12, 0.42, 0.02) * WIDTH  # of an iris
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
    for eye in open_eyes(image, points):
        discs = iris_discs(eye, _RADII)
        best = discs.variances.argmax()
        contrast = float(discs.variances[best]) ** 0.5
        rows, columns = np.nonzero(eye.opening)
        colours = eye.window.picture[rows, columns].astype(float)
        light = colours.mean(1)
        away = np.hypot(*([columns, rows] - discs.middles[best][:, None])) / _RADII[best]
        inside = away < _INSIDE
        outside = away > _OUTSIDE
        if inside.sum() >= FEWEST:
            low, high = np.quantile(light[inside], _IRIS_SHADES)
            irises.append((np.median(colours[inside & (light >= low) & (light <= high)], axis=0), contrast))
        if outside.sum() >= FEWEST:
            bright = light >= np.quantile(light[outside], _WHITE_SHADE)
            whites.append((np.median(colours[outside & bright], axis=0), contrast))
    return _mean(irises), _mean(whites)


def _mean(colours: list[tuple[np.ndarray, float]]) -> np.ndarray | None:
    """The mean of colours (3,), each with its weight."""
    if not colours:
        return None
    values, weights = zip(*colours, strict=True)
    mean: np.ndarray = np.average(values, axis=0, weights=np.array(weights) + 1e-9)
    return mean
