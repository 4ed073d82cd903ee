"""What a parsed picture shows of a head: what of it can be painted, and what is before it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from caricli.structures.parsing import Region

_SKIN = (
    *(Region.SKIN, Region.BROWS, Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.EARS),
    *(Region.BEARD, Region.NECK),
)
_PAINT = (*_SKIN, Region.HAIR)
_WORN = (Region.GLASSES, Region.HAT)
_LEAST = 0.2  # of what the mesh covers: with less skin and hair in it, this head was not seen


@dataclass(frozen=True, eq=False)
class ParsedHead:
    """A head in a picture.

    whole: (H, W) bool, all of it, with what it wears and what is held before it. paint: (H, W) bool, skin and hair,
    without glasses, hats and hands.
    """

    whole: np.ndarray
    paint: np.ndarray


def parsed_head(regions: np.ndarray, pixels: np.ndarray) -> ParsedHead | None:
    """Find the head that a mesh covers.

    regions: (H, W) values of Region. pixels: (H, W) bool, those that the mesh covers.
    Returns ParsedHead, or None where it was not seen: there is little skin and hair among these pixels, or none.
    """
    if (np.isin(regions, _PAINT) & pixels).sum() <= _LEAST * pixels.sum():
        return None
    head = np.isin(regions, (*_PAINT, *_WORN)) | ((regions == Region.OTHER) & pixels)
    parts, _ = label(head)
    # Other people in the picture do not hang together with this head.
    whole = head & np.isin(parts, np.unique(parts[pixels & head]))
    return ParsedHead(whole, whole & np.isin(regions, _PAINT))
