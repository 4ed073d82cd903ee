"""The border of hair where a picture has it, near to where a network says that it is."""

import cv2
import numpy as np

from caricli.methods.hair.settings import MaskSettings

_ROUNDS = 4  # of GrabCut


def cut_hair(image: np.ndarray, hair: np.ndarray, size: float, settings: MaskSettings) -> np.ndarray:
    """Cut hair out by its colours (GrabCut), starting from a mask whose border is a few pixels off.

    image: (H, W, 3) uint8. hair: (H, W) bool, some of it. size: pixels, of the face. settings: how far around the
    border pixels are asked, and how fine.
    Returns (H, W) bool; what was given where it leaves nothing to compare with.
    """
    rows, columns = np.nonzero(hair)
    around = int(2 * settings.beyond * size) + 2
    part = np.s_[
        max(rows.min() - around, 0) : rows.max() + around + 1,
        max(columns.min() - around, 0) : columns.max() + around + 1,
    ]
    picture = image[part]
    zoom = min(1.0, settings.side / max(picture.shape[:2]))
    small = cv2.resize(picture, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA) if zoom < 1 else picture
    given = cv2.resize(hair[part].astype(np.uint8), small.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    labels = np.where(cv2.dilate(given, _disc(settings.beyond * zoom * size)) > 0, cv2.GC_PR_BGD, cv2.GC_BGD)
    labels[given > 0] = cv2.GC_PR_FGD
    labels[cv2.erode(given, _disc(settings.within * zoom * size)) > 0] = cv2.GC_FGD
    labels = labels.astype(np.uint8)
    if not given.any() or not (labels == cv2.GC_BGD).any():
        return hair
    cv2.setRNGSeed(0)
    background, foreground = np.zeros((2, 1, 65))
    nowhere = (0, 0, 0, 0)  # a rectangle is not read where labels are given
    cv2.grabCut(np.ascontiguousarray(small[..., ::-1]), labels, nowhere, background, foreground, _ROUNDS)
    cut = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    whole = np.zeros_like(hair)
    whole[part] = cv2.resize(cut, picture.shape[1::-1], interpolation=cv2.INTER_LINEAR) > 0
    return whole


def _disc(radius: float) -> np.ndarray:
    reach = max(round(radius), 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
