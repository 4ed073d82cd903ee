"""What a picture says of where the skin of a face is, around its landmarks."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.methods.reconstruct.settings import EvidenceSettings
from caricli.render.pixels.inside_polygon import inside_polygon
from caricli.render.pixels.widen_mask import widen_mask
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.structures import Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import BROW_LEFT, BROW_RIGHT, EYE_LEFT, EYE_RIGHT, JAW, LIPS, OUTLINE
from caricli.structures.parsing import Region
from caricli.structures.zoomed_pixels import zoomed_pixels

_SETTINGS = EvidenceSettings()
_FEATURES = (EYE_LEFT, EYE_RIGHT, LIPS, BROW_LEFT, BROW_RIGHT)
_NO_FACE = (Region.BACKGROUND, Region.HAIR, Region.HAT, Region.NECK, Region.CLOTH, Region.OTHER)
_HIDING = (Region.HAIR, Region.HAT)
_LEVELS = 256
_TAILS = 4  # standard deviations, to where a colour is spread


@dataclass(frozen=True, eq=False)
class PictureEvidence:
    """A window of a picture at the size that it is looked at, where the landmarks' diagonal is always the same.

    skin: (H, W) from -1, surely not of the face's skin by its colour, to 1; what is seen to be an ear counts more, and
    what is seen to be no part of a face less. gradient: (H, W, 2), how colours change to the right and down, levels of
    Lab a pixel; none on the face and along its marked outline. hiding: (H, W) bool, hair and hats that are seen, behind
    which there may be more of an ear. inside: (H, W) bool, what the landmarks enclose.
    covered: (H, W) bool, what the fitted mesh covers. lab: (H, W, 3) uint8, the colours. corner: (2,) pixels of the
    picture, where the window begins. zoom: (2,) of its axes.
    """

    skin: np.ndarray
    gradient: np.ndarray
    hiding: np.ndarray
    inside: np.ndarray
    covered: np.ndarray
    lab: np.ndarray
    corner: np.ndarray
    zoom: np.ndarray

    def to_window(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the picture to those of the window."""
        return (pixels + 0.5 - self.corner) * self.zoom - 0.5

    def to_picture(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the window to those of the picture."""
        return (pixels + 0.5) / self.zoom + self.corner - 0.5


def picture_evidence(face: Face, points: np.ndarray, picture: ParsedPicture) -> PictureEvidence:
    """Look at a picture around landmarks.

    Skin has the colours that are seen inside the outline, without eyes, brows and mouth; the rest has those of what
    neither the landmarks enclose nor the fitted mesh covers.

    face: Face with the camera of the picture. points: (L, 2) pixels, NaN where unknown; all of the 68 that stand on
    the outline are known. picture: ParsedPicture. Raises InputError when the landmarks are outside.
    """
    corner, crop = _window(points, picture.pixels)
    scale = _SETTINGS.diagonal / np.linalg.norm(np.nanmax(points, axis=0) - np.nanmin(points, axis=0))
    size = np.maximum(np.rint(scale * np.array(crop.shape[1::-1])).astype(int), 1)
    zoom = size / crop.shape[1::-1]
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    lab = cv2.cvtColor(cv2.resize(crop, size.tolist(), interpolation=way), cv2.COLOR_RGB2LAB)
    marks = zoomed_pixels(points, zoom, corner)
    placed = face.require_camera().place(face.vertices)
    placed[:, :2] = zoomed_pixels(placed[:, :2], zoom, corner)
    covered = covered_pixels(placed, face.faces, *lab.shape[1::-1])
    inside = inside_polygon(marks[list(OUTLINE)], lab.shape[:2])
    skin = _skin_odds(lab, _bare_skin(inside, marks), ~(inside | widen_mask(covered, 1)))
    hiding = np.zeros(skin.shape, bool)
    if picture.regions is not None:
        first = corner.astype(int)
        labels = picture.regions[first[1] : first[1] + len(crop), first[0] : first[0] + crop.shape[1]]
        labels = cv2.resize(labels, size.tolist(), interpolation=cv2.INTER_NEAREST_EXACT)
        skin = np.clip(skin + _SETTINGS.label * _ear_odds(labels), -1, 1)
        hiding = np.isin(labels, _HIDING)
    gradient = _gradient(lab)
    jaw = np.zeros(inside.shape, np.uint8)
    cv2.polylines(jaw, [np.rint(marks[list(JAW)]).astype(np.int32)], False, 1, 2 * _SETTINGS.line)
    gradient[inside | (jaw > 0)] = 0
    return PictureEvidence(skin, gradient, hiding, inside, covered, lab, corner, zoom)


def _window(points: np.ndarray, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner (2,) of the part of a picture around the landmarks, and this part."""
    low = np.nanmin(points, axis=0)
    high = np.nanmax(points, axis=0)
    around = _SETTINGS.reach * np.linalg.norm(high - low)
    size = image.shape[1::-1]
    first = np.clip(np.floor(low - around), 0, size).astype(int)
    last = np.clip(np.ceil(high + around), 0, size).astype(int)
    if (last <= first).any():
        raise InputError("expected the picture that the landmarks belong to, found them outside")
    return first.astype(float), np.ascontiguousarray(image[first[1] : last[1], first[0] : last[0]])


def _bare_skin(inside: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """(H, W) bool: well inside the outline, and off eyes, brows and mouth."""
    bare = ~widen_mask(~inside, 2)
    for numbers in _FEATURES:
        feature = marks[[k for k in numbers if np.isfinite(marks[k]).all()]]
        if len(feature) > 1:
            hull = cv2.convexHull(np.rint(feature).astype(np.int32))[:, 0]
            bare &= ~widen_mask(inside_polygon(hull, inside.shape), _SETTINGS.margin)
    return bare


def _skin_odds(lab: np.ndarray, skin: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """(H, W) from -1 to 1: logarithms of the odds that a colour is of the one mask's pixels and not of the other's."""
    smooth = cv2.GaussianBlur(lab, (0, 0), _SETTINGS.blur)
    place = tuple(np.moveaxis(smooth.astype(int) * _SETTINGS.bins // _LEVELS, 2, 0))
    odds = [
        np.log(_histogram(smooth, mask, spread)[place] + _SETTINGS.rare)
        for mask, spread in ((skin, _SETTINGS.skin_spread), (rest, _SETTINGS.rest_spread))
    ]
    return np.clip((odds[0] - odds[1]) / _SETTINGS.certain, -1, 1)


def _ear_odds(labels: np.ndarray) -> np.ndarray:
    """(H, W): 1 where labels (H, W) say ear, -1 where they say no part of a face."""
    ears = cv2.GaussianBlur((labels == Region.EARS).astype(np.float32), (0, 0), _SETTINGS.label_blur) > 0.5
    return np.where(ears, 1.0, -1.0 * np.isin(labels, _NO_FACE))


def _histogram(lab: np.ndarray, mask: np.ndarray, spread: tuple[float, ...]) -> np.ndarray:
    """Smooth shares of colours; all the same where the mask is empty."""
    bins = _SETTINGS.bins
    counts = cv2.calcHist([lab], [0, 1, 2], mask.astype(np.uint8), list(bins), [0, _LEVELS] * 3).astype(float)
    if not mask.any():
        counts += 1
    counts /= counts.sum()
    for axis, width in enumerate(spread):
        last = np.moveaxis(counts, axis, 2)
        lines = np.ascontiguousarray(last).reshape(-1, bins[axis])
        size = (2 * round(_TAILS * width) + 1, 1)
        smooth = cv2.GaussianBlur(lines, size, width, sigmaY=1, borderType=cv2.BORDER_REFLECT)
        counts = np.moveaxis(smooth.reshape(last.shape), 2, axis)
    return counts


def _gradient(lab: np.ndarray) -> np.ndarray:
    """(H, W, 2) of the channel that changes most."""
    smooth = cv2.GaussianBlur(lab.astype(np.float32), (0, 0), _SETTINGS.edge_blur)
    ways = np.stack([cv2.Sobel(smooth, cv2.CV_32F, *way, ksize=3, scale=1 / 8) for way in ((1, 0), (0, 1))], -1)
    strongest = (ways**2).sum(-1).argmax(2)
    return np.take_along_axis(ways, strongest[..., None, None], 2)[:, :, 0]
