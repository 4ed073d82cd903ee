"""What of a head in a picture is skin that no hair covers or colours."""

import numpy as np

from caricli.methods.hair.dress_hair import DressedHair
from caricli.methods.texture.another_colour import lab_colours, of_another_colour
from caricli.methods.texture.distance_to import distance_to
from caricli.methods.texture.mean_colours import mean_colours
from caricli.methods.texture.parsed_head import ParsedHead

_MARGIN = 0.015  # of the face's height: as far around hair the skin has its colour or its shadow
_BORDER = 0.05  # of the same: so near to its border a head may show hair that no shell holds, or a line
_ACROSS = 0.1  # of the face's height: standard deviation of means of the skin's colours


def bare_skin(head: ParsedHead, dressed: DressedHair, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: what is left of the paint of a head where no hair covers or colours the skin.

    At the border of the face a line as dark as the hair, or locks that no shell holds, would be spread over the side.
    image: (H, W, 3) uint8.
    """
    height = np.ptp(dressed.face.require_landmarks()[:, 1])
    hair = dressed.mask.pixels
    face = head.whole if head.ears is None else head.whole & ~head.ears
    border = distance_to(~face) <= _BORDER * height
    coloured = hair | _like_hair(head.paint & face & ~hair, border, hair, image, _ACROSS * height)
    reach = max(_MARGIN * height, 1.0)
    bare = head.paint & (distance_to(coloured) > reach)
    # What is left in slivers between lines and the border is half of their colour.
    broad = distance_to(distance_to(~bare) > reach) <= reach
    bare &= broad | ~border
    return bare if bare.any() else head.paint


def _like_hair(skin: np.ndarray, border: np.ndarray, hair: np.ndarray, image: np.ndarray, reach: float) -> np.ndarray:
    """(H, W) bool: what of skin at the border (H, W) bool of a face looks like its hair, and not like the skin around.

    reach: pixels, standard deviation of what is around.
    """
    near = skin & border
    if not near.any():
        return near
    around = mean_colours(image, skin & ~near, reach)
    return of_another_colour(image, near, around, np.median(lab_colours(image, hair), axis=0))
