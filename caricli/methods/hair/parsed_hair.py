"""The hair of a head in a parsed picture."""

import cv2
import numpy as np
from scipy.ndimage import label

from caricli.methods.hair.cut_hair import cut_hair
from caricli.methods.hair.face_size import face_size
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.picture_zones import facial_features
from caricli.methods.hair.settings import MaskSettings
from caricli.render.pixels.distance_to import distance_to
from caricli.render.visibility.nearest_pixel import nearest_pixel
from caricli.structures import Face
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region

_AROUND = (Region.BACKGROUND, Region.CLOTH)
_NEVER = (Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.GLASSES)
_SPECKS = 0.1  # of hats and hair: with less of a hat than that among it, colours tell hair there, too
_SAME_COLOUR = 5.5  # levels of CIELAB in 8 bits, between the mean colours of hair and of what is labelled hat
_LIGHTNESS = 0.5  # how much of its difference counts there: hair is lighter where it shines
_PATCH = 0.35  # of the hair: larger parts that are labelled hat are one, whatever their colour
_CERTAIN = 0.4  # probabilities that are farther from a half


def parsed_hair(face: Face, regions: np.ndarray, pixels: np.ndarray, image: np.ndarray) -> HairMask | None:
    """The hair that hangs on a head; a few pixels of hats among it are none, and a hat beside the head is a wall.

    Regions are coarse: near their border colours say what is hair. Brows, eyes and lips stay what they are.

    face: Face with landmarks. regions: (H, W) values of Region. pixels: (H, W) bool, those that the face's mesh covers.
    image: (H, W, 3) uint8.
    Returns HairMask, whose doubt is one minus the expected intersection over union with what is hair, by its colours,
    times the share that hair has of hats and hair; or None where the network is unsure, or takes much of it for a hat.
    """
    settings = MaskSettings()
    points = face.require_landmarks()[:COUNT]
    size = face_size(face)
    hats = regions == Region.HAT
    regions = np.where(hats & ~on_head(hats, pixels), Region.BACKGROUND, regions)
    regions = np.where(_coloured_as_hair(regions, image), Region.HAIR, regions)
    hair = regions == Region.HAIR
    own = on_head(hair, pixels, settings.crumb * size**2, settings.gap * size)
    worn = (on_head(np.isin(regions, (Region.HAT, Region.HAIR)), pixels) & (regions == Region.HAT)).sum()
    doubt = float(worn / max(worn + own.sum(), 1))
    if doubt > settings.doubt:
        return None
    if own.any():
        probable = cut_hair(image, own, size, settings)
        features = facial_features(points, size, own.shape, settings) & ~own
        other = np.isin(regions, _NEVER) | ((regions == Region.HAT) & (doubt > _SPECKS))
        cut = (probable > 0.5) & ~other & ~features
        own = on_head(cut, pixels, settings.crumb * size**2, settings.gap * size)
        doubt = 1 - (1 - doubt) * _certainty(own, probable)
        if doubt > settings.unsure:
            return None
    # What colours take from the hair is what is next to it.
    beside = regions if hair.all() else regions[nearest_pixel(~hair)]
    enclosed = cv2.contourArea(cv2.convexHull(points.astype(np.float32)))
    enough = own.sum() >= settings.least * enclosed
    return HairMask(own, np.isin(beside, _AROUND) & ~own, doubt, bool(enough and doubt <= settings.doubt))


def is_before_head(mask: HairMask, pixels: np.ndarray) -> bool:
    """Whether enough of what is labelled hair is before the head (H, W) bool; else it is rather the wall behind it."""
    return bool((mask.pixels & pixels).sum() >= MaskSettings().over * mask.pixels.sum())


def _coloured_as_hair(regions: np.ndarray, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: small parts of what is labelled hat that have the mean colour of the hair: drawn hair often has
    large even places."""
    parts, count = label(regions == Region.HAT)
    parts = np.where(regions == Region.HAIR, count + 1, parts)
    sizes = np.bincount(parts.ravel(), minlength=count + 2)
    if not count or not sizes[-1]:
        return np.zeros(parts.shape, bool)
    channels = cv2.split(cv2.cvtColor(image, cv2.COLOR_RGB2LAB))
    sums = np.stack([np.bincount(parts.ravel(), values.ravel(), count + 2) for values in channels], axis=1)
    means = sums / np.maximum(sizes, 1)[:, None] * [_LIGHTNESS, 1, 1]
    alike = np.linalg.norm(means - means[-1], axis=1) < _SAME_COLOUR
    alike &= sizes < _PATCH * sizes[-1]
    alike[0] = False
    own: np.ndarray = alike[parts]
    return own


def on_head(mask: np.ndarray, pixels: np.ndarray, least: float = 0.0, gap: float = 0.0) -> np.ndarray:
    """(H, W) bool: the parts of a mask (H, W) that have more than so many pixels and some of those of the head.

    gap: pixels, what is no farther apart than this is one part.
    """
    joined = distance_to(mask) < (gap + 1) / 2
    parts = np.where(mask, label(joined)[0], 0)
    kept = np.bincount(parts.ravel()) > least
    kept &= np.bincount(parts[pixels & mask], minlength=len(kept)) > 0
    kept[0] = False
    return kept[parts]


def _certainty(mask: np.ndarray, probable: np.ndarray) -> float:
    """Expected intersection over union of a mask and what has probabilities (H, W); nine to one is certain."""
    probable = np.where(np.abs(probable - 0.5) > _CERTAIN, probable > 0.5, probable)
    return float(np.minimum(mask, probable).sum() / max(np.maximum(mask, probable).sum(), 1e-9))
