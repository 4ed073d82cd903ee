"""What of a head in a picture is skin that no hair covers or colours."""

import cv2
import numpy as np
from scipy.ndimage import binary_dilation, label

from caricli.methods.hair.dress_hair import DressedHair
from caricli.methods.hair.face_size import face_size
from caricli.methods.texture.another_colour import LIKE, lab_colours, of_another_colour
from caricli.methods.texture.mean_colours import mean_colours
from caricli.methods.texture.parsed_head import ParsedHead
from caricli.render.pixels.distance_to import distance_to
from caricli.structures.landmarks import BROW_LEFT, BROW_RIGHT, EYE_LEFT, EYE_RIGHT

_MARGIN = 0.019  # of the face's size: as far around hair the skin has its colour or its shadow
_BORDER = 0.063  # of the same: so near to its border a head may show hair that no shell holds, or a line
_EAR = 0.038  # of the same: so near to the face an ear may show a line, too
_INWARDS = 0.19  # of the same: so far in goes what hangs together with that
_STRAND = 0.38  # of the same: so near to hair what has its colour and hangs together with it is a strand
_SLIVER = 0.038  # of the same: half as wide as skin is that is left there, at least
_SHADED = 0.063  # of the same: so near to hair skin is under fine strands or their shadow
_MIXED = 3.0  # times as far from the hair's colour as from the skin's, at most, is what is mixed of both
_FEATURE = 0.038  # of the face's size: around brows and eyes, which have that colour, too
_ACROSS = 0.126  # of the same: standard deviation of means of the skin's colours


def bare_skin(head: ParsedHead, dressed: DressedHair, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: what is left of the paint of a head where no hair covers or colours the skin, if anything.

    At the border of the face a line as dark as the hair, or locks that no shell holds, would be spread over the side,
    and what of it goes on inwards would end there; strands before the forehead would be drawn on it. image: (H, W, 3)
    uint8.
    """
    size = face_size(dressed.face)
    hair = dressed.mask.pixels
    face = head.whole if head.ears is None else head.whole & ~head.ears
    inwards = distance_to(~face)
    border = inwards <= _BORDER * size
    skin = head.paint & face & ~hair
    plain = skin & (distance_to(_features(dressed)) > _FEATURE * size)
    near = plain & (distance_to(hair) <= _STRAND * size)
    outer = inwards <= _INWARDS * size
    ears = head.paint & head.whole & ~face & ~hair & (distance_to(face) <= _EAR * size)
    dark = _like_hair(skin & border | plain & outer | ears, skin & ~outer, hair, image, _ACROSS * size)
    lines = _hanging(dark, dark & (border | ears))
    strands = _hanging(_like_hair(near, skin, hair, image, _ACROSS * size), hair)
    beside = distance_to(hair) <= _SHADED * size
    shaded = _hanging(_like_hair(plain & beside, skin & ~beside, hair, image, _ACROSS * size, _MIXED), hair)
    coloured = hair | lines | strands | shaded
    reach = max(_MARGIN * size, 1.0)
    bare = head.paint & (distance_to(coloured) > reach)
    # What is left in slivers between lines and the border is half of their colour.
    slivers = ~_broad(bare, reach) & border | ~_broad(bare, _SLIVER * size) & face & outer
    return bare & ~slivers


def _broad(mask: np.ndarray, reach: float) -> np.ndarray:
    """(H, W) bool: what of a mask discs of a radius, pixels, fit into."""
    broad: np.ndarray = distance_to(distance_to(~mask) > reach) <= reach
    return broad


def _like_hair(
    near: np.ndarray, skin: np.ndarray, hair: np.ndarray, image: np.ndarray, reach: float, like: float = LIKE
) -> np.ndarray:
    """(H, W) bool: which of some pixels look like hair (H, W) bool, and not like the skin (H, W) bool around them.

    near: (H, W) bool. reach: pixels, standard deviation of what is around. like: see `of_another_colour`.
    """
    if not near.any():
        return near
    colour = np.median(lab_colours(image, hair), axis=0)
    return of_another_colour(image, near, mean_colours(image, skin, reach), colour, like)


def _features(dressed: DressedHair) -> np.ndarray:
    """(H, W) bool: lines along the brows and eyes of a face."""
    marks = np.rint(dressed.face.require_landmarks()).astype(np.int32)
    lines = np.zeros(dressed.mask.pixels.shape, np.uint8)
    cv2.polylines(lines, [marks[list(part)] for part in (BROW_RIGHT, BROW_LEFT, EYE_RIGHT, EYE_LEFT)], False, 1)
    return lines > 0


def _hanging(alike: np.ndarray, hair: np.ndarray) -> np.ndarray:
    """(H, W) bool: what of pixels that look like hair hangs together with some (H, W) bool of it."""
    parts, _ = label(binary_dilation(alike | hair))
    strands: np.ndarray = alike & np.isin(parts, np.unique(parts[hair]))
    return strands
