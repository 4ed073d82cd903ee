"""Which eyes a picture shows."""

import numpy as np

from caricli.render.pixels.inside_polygon import inside_polygon
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT
from caricli.structures.parsing import Region

_BEFORE = (Region.GLASSES, Region.HAT, Region.HAIR, Region.OTHER)
_HIDDEN = 0.5  # of what is between the lids
# Of the same, in the eye where it is most. Renders of three blinks show 0.01, 0.28 and 0.60; open eyes of seven
# pictures 0.35 (of a drawing whose other eye has 0.00) and at least 0.66.
_CLOSED = 0.2


def seen_eyes(points: np.ndarray, regions: np.ndarray) -> np.ndarray:
    """Landmarks of which those of eyes are unknown that mostly show what is before them, as lenses of dark glasses.

    So are both eyes where they are closed: hardly anything between their lids is labelled as eyes, but something is in
    the picture, which says that labels tell eyes at all.

    points: (L, 2) pixels, NaN where unknown. regions: (H, W) values of Region.
    Returns (L, 2), a copy.
    """
    points = points.copy()
    shares = []
    for eye in (EYE_LEFT, EYE_RIGHT):
        outline = points[list(eye)]
        between = regions[inside_polygon(outline, regions.shape)] if np.isfinite(outline).all() else regions[:0]
        if between.size and np.isin(between, _BEFORE).mean() > _HIDDEN:
            points[list(eye)] = np.nan
        elif between.size:
            shares.append((between == Region.EYES).mean())
    if (regions == Region.EYES).any() and shares and max(shares) < _CLOSED:
        points[[*EYE_LEFT, *EYE_RIGHT]] = np.nan
    return points
