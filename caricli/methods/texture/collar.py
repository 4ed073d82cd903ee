"""What of a neck is none, by its colours."""

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.texture.another_colour import lab_colours
from caricli.structures.parsing import Region

BARE = (Region.SKIN, Region.NOSE)
"""What shows the colours of a face's skin."""

_LIKE = 0.03  # of bare skin, that a neck's colours have to be like: highlights on skin are white, too
_UNLIKE = 12.0  # in CIELAB: what is no nearer to so much of it is a collar
_ROUND = 2.0  # in CIELAB: nearer colours count as one


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
        own, numbers = _shades(lab_colours(image, bare) * weights)
        counts = np.bincount(numbers)
        colours, numbers = _shades(lab_colours(image, neck) * weights)
        like = [counts[near].sum() for near in KDTree(own).query_ball_point(colours, _UNLIKE)]
        collar[neck] = (np.array(like) < _LIKE * counts.sum())[numbers]
    return collar


def _shades(colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(S, 3) distinct colours of (N, 3) where near ones count as one, and which of them (N,) each is."""
    rounded = np.round(colours / _ROUND).astype(int)
    keys = rounded @ [1, 1 << 16, 1 << 32]
    _, first, numbers = np.unique(keys, return_index=True, return_inverse=True)
    return _ROUND * rounded[first], numbers
