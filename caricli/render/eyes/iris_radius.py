"""How large the irises of a picture are."""

import numpy as np

from caricli.render.eyes.eye_window import WIDTH
from caricli.render.eyes.iris_discs import iris_discs, open_eyes

_RADII = np.arange(0.10, 0.46, 0.02) * WIDTH
_EVEN = 1.0  # square levels of 255: with less variance between its lids an eye has one colour, and no iris


def iris_radius(image: np.ndarray, points: np.ndarray) -> tuple[float, float]:
    """The radius for which discs in both eyes part the pixels between the lids best.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown.
    Returns pixels, and what share of their variance it explains, from 0 to 1; (0, 0) where not both eyes are seen, or
    each has one colour.
    """
    eyes = list(open_eyes(image, points))
    if len(eyes) < 2:
        return 0.0, 0.0
    zooms = np.array([eye.window.zoom for eye in eyes])
    usual = float(np.exp(np.log(zooms).mean()))
    discs = [iris_discs(eye, _RADII * zoom / usual) for eye, zoom in zip(eyes, zooms, strict=True)]
    between = np.sum([each.variances for each in discs], axis=0)
    best = int(between.argmax())
    whole = sum(each.whole for each in discs)
    if whole < _EVEN:
        return 0.0, 0.0
    return float(_RADII[best] / usual), float(np.clip(between[best] / whole, 0, 1))
