"""What a parsed picture shows of a head: what of it can be painted, and what is before it."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import label
from scipy.spatial import KDTree

from caricli.structures.parsing import Region

_SKIN = (
    *(Region.SKIN, Region.BROWS, Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.EARS),
    *(Region.BEARD, Region.NECK),
)
_PAINT = (*_SKIN, Region.HAIR)
_WORN = (Region.GLASSES, Region.HAT)
_BARE = (Region.SKIN, Region.NOSE)
_COLOURS = 500  # of bare skin, to compare a neck's with
_SEVERAL = 15  # of them a neck has to be like: highlights on skin are white, too
_UNLIKE = 12.0  # in CIELAB: what is no nearer to so many is a collar
_LEAST = 0.2  # of what the mesh covers: with less skin and hair in it, this head was not seen


@dataclass(frozen=True, eq=False)
class ParsedHead:
    """A head in a picture.

    whole: (H, W) bool, all of it, with what it wears and what is held before it. paint: (H, W) bool, skin and hair,
    without glasses, hats and hands.
    """

    whole: np.ndarray
    paint: np.ndarray


def parsed_head(regions: np.ndarray, pixels: np.ndarray, image: np.ndarray) -> ParsedHead | None:
    """Find the head that a mesh covers.

    A collar is easily taken for neck; it is told by its colours.
    regions: (H, W) values of Region. pixels: (H, W) bool, those that the mesh covers. image: (H, W, 3) uint8.
    Returns ParsedHead, or None where it was not seen: there is little skin and hair among these pixels, or none.
    """
    if (np.isin(regions, _PAINT) & pixels).sum() <= _LEAST * pixels.sum():
        return None
    head = np.isin(regions, (*_PAINT, *_WORN)) | ((regions == Region.OTHER) & pixels)
    parts, _ = label(head)
    # Other people in the picture do not hang together with this head.
    whole = head & np.isin(parts, np.unique(parts[pixels & head]))
    return ParsedHead(whole, whole & np.isin(regions, _PAINT) & ~_collar(regions, whole & pixels, image))


def _collar(regions: np.ndarray, head: np.ndarray, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: what of a neck has none of the colours of the bare skin of the same head (H, W) bool."""
    neck = head & (regions == Region.NECK)
    bare = head & np.isin(regions, _BARE)
    collar = np.zeros_like(neck)
    if neck.any() and bare.any():
        colours = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
        own = colours[bare]
        some = own[np.linspace(0, len(own) - 1, min(_COLOURS, len(own))).astype(int)]
        away, _ = KDTree(some).query(colours[neck], k=[min(_SEVERAL, len(some))])
        collar[neck] = away[:, 0] > _UNLIKE
    return collar
