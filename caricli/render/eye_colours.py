"""The colours of the eyes in a picture."""

import cv2
import numpy as np

EYES = range(36, 42), range(42, 48)
_IRIS, _FEWEST = 0.2, 12


def eye_colours(image, points):
    """Colours of iris and white, from the pixels between the lids.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown.
    Returns two (3,) arrays, sRGB 0 to 255, or None for either that cannot be seen.
    """
    irises, whites = [], []
    for eye in EYES:
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
            # Pupil and reflections are the extremes of what is inside.
            low, high = np.quantile(light[inside], (0.3, 0.8))
            irises.append(np.median(colours[inside & (light >= low) & (light <= high)], axis=0))
        if (~inside).sum() >= _FEWEST // 2:
            whites.append(np.median(colours[~inside & (light >= np.quantile(light[~inside], 0.6))], axis=0))
    return tuple(np.mean(found, axis=0) if found else None for found in (irises, whites))
