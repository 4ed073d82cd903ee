"""The hair of a head in a parsed picture."""

import cv2
import numpy as np
from scipy.ndimage import label

from caricli.methods.hair.cut_hair import cut_hair
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import MaskSettings
from caricli.render.nearest_pixel import nearest_pixel
from caricli.structures import Face
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region

_AROUND = (Region.BACKGROUND, Region.CLOTH)
_NEVER = (Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.GLASSES, Region.HAT)


def parsed_hair(
    face: Face,
    regions: np.ndarray,
    pixels: np.ndarray,
    image: np.ndarray,
    settings: MaskSettings = MaskSettings(),  # noqa: B008 (frozen)
) -> HairMask | None:
    """The hair that hangs on a head; hats are none, and where they hide much of it, it is doubtful.

    Regions are coarse: near their border colours say what is hair.

    face: Face with landmarks. regions: (H, W) values of Region. pixels: (H, W) bool, those that the face's mesh covers.
    image: (H, W, 3) uint8.
    Returns HairMask, whose doubt is the hats' share of hats and hair; or None where by its colours most of what is said
    to be hair is none, or hair goes on far beyond: then this is rather the wall behind it.
    """
    points = face.require_landmarks()[:COUNT]
    area = float(np.ptp(points, axis=0).max()) ** 2
    hair = regions == Region.HAIR
    parts, _ = label(hair)
    sizes = np.bincount(parts.ravel())
    on_head = np.zeros(len(sizes), bool)
    on_head[np.unique(parts[pixels & hair])] = True
    own = (on_head & (sizes > settings.speckle * area))[parts] & hair
    hats = ((regions == Region.HAT) & pixels).sum()
    doubt = float(hats / max(hats + own.sum(), 1))
    if doubt <= settings.doubt and own.any():
        size = float(np.sqrt(area))
        cut = cut_hair(image, own, size, settings)
        if (cut & own).sum() < (1 - settings.doubt) * (cut | own).sum():
            return None
        own = cut & ~np.isin(regions, _NEVER)
    # What colours take from the hair is what is next to it.
    beside = regions if hair.all() else regions[nearest_pixel(~hair)]
    enclosed = cv2.contourArea(cv2.convexHull(points[np.isfinite(points).all(1)].astype(np.float32)))
    enough = own.sum() >= settings.least * enclosed
    return HairMask(own, np.isin(beside, _AROUND) & ~own, doubt, bool(enough and doubt <= settings.doubt))
