"""The hair of a head in a parsed picture."""

import numpy as np
from scipy.ndimage import label

from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import MaskSettings
from caricli.structures import Face
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region

_AROUND = (Region.BACKGROUND, Region.CLOTH)


def parsed_hair(
    face: Face,
    regions: np.ndarray,
    pixels: np.ndarray,
    settings: MaskSettings = MaskSettings(),  # noqa: B008 (frozen)
) -> HairMask:
    """The hair that hangs on a head; hats are none, and where they hide much of it, it is doubtful.

    face: Face with landmarks. regions: (H, W) values of Region. pixels: (H, W) bool, those that the face's mesh covers.
    Returns HairMask, whose doubt is the hats' share of hats and hair.
    """
    area = float(np.ptp(face.require_landmarks()[:COUNT], axis=0).max()) ** 2
    hair = regions == Region.HAIR
    parts, _ = label(hair)
    sizes = np.bincount(parts.ravel())
    on_head = np.zeros(len(sizes), bool)
    on_head[np.unique(parts[pixels & hair])] = True
    own = (on_head & (sizes > settings.speckle * area))[parts] & hair
    hats = ((regions == Region.HAT) & pixels).sum()
    doubt = float(hats / max(hats + own.sum(), 1))
    enough = own.sum() >= settings.least * area
    return HairMask(own, np.isin(regions, _AROUND), doubt, bool(enough and doubt <= settings.doubt))
