"""Which pixels of a picture show the head that was fitted to it."""

import cv2
import numpy as np

from caricli.render.rasterise import rasterise
from caricli.structures.landmarks import OUTLINE

_SIDE = 800  # pixels; finer than this the outline of a region is no more exact
_ROUNDS = 4  # of GrabCut
_CORE = 0.04  # of the face's size: as far inside its outline a pixel is surely the face
_BAND = 0.06  # of the face's size: as far outside mesh and outline a pixel may be the head
_FOREHEAD = 0.15  # of the face's size, below the brows: what the mesh covers above that is likely there
_SPECKLE = 1.5  # pixels: smaller things are noise


def mask_face(image: np.ndarray, projected: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Cut a head out by its colours (GrabCut), starting from where the fitted mesh and its landmarks are.

    image: (H, W, 3) uint8. projected: (V, 3), pixels and depth, as `rasterise` takes them. faces: (F, 3). points:
    (L, 2) landmarks, pixels.
    Returns (H, W) bool; what the landmarks enclose where the colours tell nothing.
    """
    height, width = image.shape[:2]
    shrink = min(1.0, _SIDE / max(height, width))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA) if shrink < 1 else image
    rows, columns = small.shape[:2]
    head = rasterise(shrink * projected, faces, columns, rows).face >= 0
    enclosed = np.zeros((rows, columns), np.uint8)
    given = np.isfinite(points).all(1)
    outline = np.round(shrink * points[[k for k in OUTLINE if given[k]]]).astype(np.int32)
    cv2.fillPoly(enclosed, [outline], 1)
    labels = _first_guess(head, enclosed, outline)
    inner = labels == cv2.GC_FGD
    mask = _cut(small, labels, inner, enclosed) if (labels == cv2.GC_BGD).any() and inner.any() else enclosed
    return cv2.resize(mask, (width, height), interpolation=cv2.INTER_LINEAR) > 0


def _first_guess(head: np.ndarray, enclosed: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Labels (H, W) of GrabCut by what mesh and landmarks cover."""
    size = max(np.ptp(outline, axis=0).max(), 8)
    near = cv2.dilate((head | (enclosed > 0)).astype(np.uint8), _disc(_BAND * size)) > 0
    labels = np.where(near, cv2.GC_PR_BGD, cv2.GC_BGD).astype(np.uint8)
    # What is above the eyes is likely there, under hair or not; ears, cheeks and neck may be narrower than the head's.
    above = np.arange(len(head))[:, None] < outline[:, 1].min() + _FOREHEAD * size
    labels[(head & above) | (enclosed > 0)] = cv2.GC_PR_FGD
    labels[cv2.erode(enclosed, _disc(_CORE * size)) > 0] = cv2.GC_FGD
    return labels


def _cut(image: np.ndarray, labels: np.ndarray, inner: np.ndarray, enclosed: np.ndarray) -> np.ndarray:
    """Mask (H, W) uint8 of what has the colours of the face and hangs together with it, or what was enclosed."""
    cv2.setRNGSeed(0)
    background, foreground = np.zeros((2, 1, 65))
    nowhere = (0, 0, 0, 0)  # a rectangle is not read where labels are given
    cv2.grabCut(np.ascontiguousarray(image[..., ::-1]), labels, nowhere, background, foreground, _ROUNDS)
    likely = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    cut = np.asarray(cv2.morphologyEx(likely, cv2.MORPH_OPEN, _disc(_SPECKLE)))
    _, parts = cv2.connectedComponents(cut)
    inside = parts[inner & (cut > 0)]
    return (parts == np.bincount(inside[inside > 0]).argmax()).astype(np.uint8) if (inside > 0).any() else enclosed


def _disc(radius: float) -> np.ndarray:
    reach = max(int(round(radius)), 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
