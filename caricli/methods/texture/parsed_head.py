"""What a parsed picture shows of a head: what of it can be painted, and what is before it."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import label

from caricli.methods.texture.another_colour import of_another_colour
from caricli.methods.texture.collar import BARE, find_collar
from caricli.methods.texture.mean_colours import mean_colours
from caricli.render.pixels.distance_to import distance_to
from caricli.structures.parsing import HEAD_REGIONS, Region

_PAINT = (*HEAD_REGIONS, Region.HAIR)
_WORN = (Region.GLASSES, Region.HAT)
_AROUND = 0.006  # of the mesh's height in the picture: border of a collar, and least half of a neck's breadth
_REACH = 0.04  # of the same: so near to what is behind a head its region may show this
_SPECK = 3  # pixels that differ from those around them by chance, as of a drawing's grain
_LEAST = 0.2  # of what the mesh covers: with less skin and hair in it, this head was not seen


@dataclass(frozen=True, eq=False)
class ParsedHead:
    """A head in a picture.

    whole: (H, W) bool, all of it, with what it wears and what is held before it. paint: (H, W) bool, skin and hair,
    without glasses, hats and hands. ears: (H, W) bool, or None where nobody knows.
    """

    whole: np.ndarray
    paint: np.ndarray
    ears: np.ndarray | None = None


def parsed_head(regions: np.ndarray, pixels: np.ndarray, image: np.ndarray) -> ParsedHead | None:
    """Find the head that a mesh covers.

    A collar is easily taken for neck; it is told by its colours, and what is beyond it is no neck either. So is what is
    behind the head taken for skin at its border, and told by its colours.

    regions: (H, W) values of Region. pixels: (H, W) bool, those that the mesh covers. image: (H, W, 3) uint8.
    Returns ParsedHead, or None where it was not seen: there is little skin and hair among these pixels, or none.
    """
    if (np.isin(regions, _PAINT) & pixels).sum() <= _LEAST * pixels.sum():
        return None
    head = np.isin(regions, (*_PAINT, *_WORN)) | ((regions == Region.OTHER) & pixels)
    parts, _ = label(head)
    # Other people in the picture do not hang together with this head.
    whole = head & np.isin(parts, np.unique(parts[pixels & head]))
    own = whole & pixels
    height = np.ptp(np.flatnonzero(pixels.any(1)))
    around = round(_AROUND * height)
    collar = find_collar(regions, own, image)
    if collar.any():
        # Beyond the mesh, too, whose outermost vertices see what is beside it.
        collar = whole & (regions == Region.NECK) & ~_bare_neck(regions, own & ~collar, collar, around)
    bare = whole & ~collar
    behind = _behind(regions, bare, image, _REACH * height)
    return ParsedHead(whole, bare & np.isin(regions, _PAINT) & ~behind, regions == Region.EARS)


def _behind(regions: np.ndarray, head: np.ndarray, image: np.ndarray, reach: float) -> np.ndarray:
    """(H, W) bool: what of the skin of a head (H, W) bool has the colours of what is behind it, not its own.

    reach: pixels, so near to the border of the head colours are asked, and so far from it they are learnt.
    """
    skin = head & np.isin(regions, HEAD_REGIONS)
    back = regions == Region.BACKGROUND
    near = skin & (distance_to(back) <= reach)
    if not near.any():
        return near
    inside, outside = (
        mean_colours(image, part, reach) for part in (skin & ~near, back & (distance_to(head) > reach / 2))
    )
    behind = of_another_colour(image, near, inside, outside)
    # What touches what is behind the head is its border, however small.
    parts, _ = label(behind | back, np.ones((3, 3)))
    return behind & (np.bincount(parts.ravel()) > _SPECK)[parts]


def _bare_neck(regions: np.ndarray, head: np.ndarray, collar: np.ndarray, around: int) -> np.ndarray:
    """(H, W) bool: what of the neck of a head (H, W) bool hangs together with its skin, away from a collar (H, W) bool.

    around: pixels, of its border that is a mixture, and of what is too thin to hang together.
    """
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * around + 1, 2 * around + 1))
    neck = head & (regions == Region.NECK) & (cv2.dilate(collar.astype(np.uint8), disc) == 0)
    neck = cv2.morphologyEx(neck.astype(np.uint8), cv2.MORPH_OPEN, disc) > 0
    bare = head & np.isin(regions, BARE)
    parts, _ = label(neck | (cv2.dilate(bare.astype(np.uint8), disc) > 0))
    return neck & np.isin(parts, np.unique(parts[bare]))
