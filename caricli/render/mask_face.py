"""Which pixels of a picture show the head that was fitted to it."""

import cv2
import numpy as np

from caricli.render.rasterise import rasterise

OUTLINE = (*range(17), *range(26, 16, -1))
"""Landmarks around the face: along the jaw, back along the brows."""

_SIDE, _ROUNDS = 800, 4
_CORE, _BAND, _FOREHEAD = 0.04, 0.06, 0.15


def mask_face(image, projected, faces, points):
    """Cut a head out by its colours (GrabCut), starting from where the fitted mesh and its landmarks are.

    image: (H, W, 3) uint8. projected: (V, 3), pixels and depth, as `rasterise` takes them. faces: (F, 3). points:
    (L, 2) landmarks, pixels. Returns (H, W) bool; what the landmarks enclose where the colours tell nothing.
    """
    height, width = image.shape[:2]
    # Finer than this the outline of a region is no more exact.
    shrink = min(1.0, _SIDE / max(height, width))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA) if shrink < 1 else image
    rows, columns = small.shape[:2]
    head = rasterise(shrink * projected, faces, columns, rows).face >= 0
    core = np.zeros((rows, columns), np.uint8)
    known = np.isfinite(points).all(1)
    outline = np.round(shrink * points[[k for k in OUTLINE if known[k]]]).astype(np.int32)
    cv2.fillPoly(core, [outline], 1)
    size, top = max(np.ptp(outline, axis=0).max(), 8), outline[:, 1].min()
    inner = cv2.erode(core, _disc(_CORE * size)) > 0
    near = cv2.dilate((head | (core > 0)).astype(np.uint8), _disc(_BAND * size)) > 0
    labels = np.where(near, cv2.GC_PR_BGD, cv2.GC_BGD).astype(np.uint8)
    # What is above the eyes is likely there, under hair or not; ears, cheeks and neck may be narrower than the head's.
    above = np.arange(rows)[:, None] < top + _FOREHEAD * size
    labels[(head & above) | (core > 0)] = cv2.GC_PR_FGD
    labels[inner] = cv2.GC_FGD
    if (labels == cv2.GC_BGD).any() and inner.any():
        cv2.setRNGSeed(0)
        cv2.grabCut(np.ascontiguousarray(small[..., ::-1]), labels, None, *np.zeros((2, 1, 65)), _ROUNDS)
        found = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD))
        found = cv2.morphologyEx(found.astype(np.uint8), cv2.MORPH_OPEN, _disc(1.5))
        # What does not hang together with the face is something else.
        _, parts = cv2.connectedComponents(found)
        inside = parts[inner & (found > 0)]
        core = (parts == np.bincount(inside[inside > 0]).argmax()).astype(np.uint8) if (inside > 0).any() else core
    return cv2.resize(core, (width, height), interpolation=cv2.INTER_LINEAR) > 0


def _disc(radius):
    reach = max(int(round(radius)), 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
