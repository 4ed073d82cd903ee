"""The colours of the eyes in a picture."""

import cv2
import numpy as np

from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT

_IRIS = 0.2  # of the eye's width, from its middle: as far the iris is sure to reach
_FEWEST = 12  # pixels between the lids: fewer say nothing about a colour
_IRIS_SHADES = (0.3, 0.8)  # quantiles of brightness: pupil and reflections are the extremes of what is inside
_WHITE_SHADE = 0.8  # quantile of brightness: lashes and shadows of the lids are darker than the white


def eye_colours(image: np.ndarray, points: np.ndarray) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Colours of iris and white, from the pixels between the lids.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown.
    Returns two (3,) arrays, sRGB 0 to 255, or None for either that cannot be seen.
    """
    irises: list[np.ndarray] = []
    whites: list[np.ndarray] = []
    for eye in (EYE_RIGHT, EYE_LEFT):
        outline = points[list(eye)]
        if not np.isfinite(outline).all():
            continue
        mask = np.zeros(image.shape[:2], np.uint8)
        cv2.fillPoly(mask, [np.round(outline).astype(np.int32)], 1)
        rows, columns = np.nonzero(mask)
        if len(rows) < _FEWEST:
            continue
        colours = image[rows, columns].astype(float)
        away = np.hypot(columns - outline[:, 0].mean(), rows - outline[:, 1].mean())
        inside = away < _IRIS * np.ptp(outline[:, 0])
        light = colours.mean(1)
        if inside.sum() >= _FEWEST // 2:
            low, high = np.quantile(light[inside], _IRIS_SHADES)
            irises.append(np.median(colours[inside & (light >= low) & (light <= high)], axis=0))
        if (~inside).sum() >= _FEWEST // 2:
            bright = light >= np.quantile(light[~inside], _WHITE_SHADE)
            whites.append(np.median(colours[~inside & bright], axis=0))
    return _mean(irises), _mean(whites)


def _mean(colours: list[np.ndarray]) -> np.ndarray | None:
    return np.mean(colours, axis=0) if colours else None
