"""Which eyes a picture shows."""

import numpy as np

from caricli.render.pixels.inside_polygon import inside_polygon
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT
from caricli.structures.parsing import Region

_BEFORE = (Region.GLASSES, Region.HAT, Region.HAIR, Region.OTHER)
_HIDDEN = 0.5  # of what is between the lids


def seen_eyes(points: np.ndarray, regions: np.ndarray) -> np.ndarray:
    """Landmarks of which those of eyes are unknown that mostly show what is before them, as lenses of dark glasses.

    points: (L, 2) pixels, NaN where unknown. regions: (H, W) values of Region.
    Returns (L, 2), a copy.
    """
    points = points.copy()
    for eye in (EYE_LEFT, EYE_RIGHT):
        outline = points[list(eye)]
        between = regions[inside_polygon(outline, regions.shape)] if np.isfinite(outline).all() else regions[:0]
        if between.size and np.isin(between, _BEFORE).mean() > _HIDDEN:
            points[list(eye)] = np.nan
    return points
