"""What of a neck is none, by its colours."""

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.texture.another_colour import lab_colours
from caricli.structures.parsing import Region

BARE = (Region.SKIN, Region.NOSE)
"""What shows the colours of a face's skin."""

_COLOURS = 500  # of bare skin, to compare a neck's with
_SEVERAL = 15  # of them a neck has to be like: highlights on skin are white, too
_UNLIKE = 12.0  # in CIELAB: what is no nearer to so many is a collar


def find_collar(regions: np.ndarray, head: np.ndarray, image: np.ndarray, lightness: float = 1.0) -> np.ndarray:
    """(H, W) bool: what of a neck has none of the colours of the bare skin of the same head (H, W) bool.

    regions: (H, W) values of Region. image: (H, W, 3) uint8. lightness: how much it counts beside hue and saturation:
    little where the shadow of a chin is skin, too.
    """
    neck = head & (regions == Region.NECK)
    bare = head & np.isin(regions, BARE)
    collar = np.zeros_like(neck)
    if neck.any() and bare.any():
        weights = np.array([lightness, 1, 1], np.float32)
        own, colours = (lab_colours(image, part) * weights for part in (bare, neck))
        some = own[np.linspace(0, len(own) - 1, min(_COLOURS, len(own))).astype(int)]
        away, _ = KDTree(some).query(colours, k=[min(_SEVERAL, len(some))])
        collar[neck] = away[:, 0] > _UNLIKE
    return collar
