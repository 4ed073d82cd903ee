"""Which pixels of a picture show the head that was fitted to it."""

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.structures import Face, Landmarks
from caricli.structures.landmarks import OUTLINE
from caricli.structures.zoomed_pixels import zoomed_pixels

_LEAST = 1e-4  # of a picture: its face fills at least this share; with less it is of another picture
_SIDE = 800  # pixels; finer than this the outline of a region is no more exact
_ROUNDS = 4  # of GrabCut
_CORE = 0.04  # of the face's size: as far inside its outline a pixel is surely the face
_BAND = 0.06  # of the face's size: as far outside mesh and outline a pixel may be the head
_FOREHEAD = 0.15  # of the face's size, below the brows: what the mesh covers above that is likely there
_SPECKLE = 1.5  # pixels: smaller things are noise


def mesh_pixels(face: Face, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: pixels that the mesh of a face covers.

    face: Face with the camera of the picture. image: (H, W, 3) uint8.
    Raises InputError when the face is outside.
    """
    pixels = _covered(face, image.shape[0], image.shape[1])
    if pixels.mean() < _LEAST:
        raise InputError("expected the picture that the face was fitted to, found it outside")
    return pixels


def mask_head(face: Face, image: np.ndarray, points: np.ndarray | None = None) -> np.ndarray:
    """Cut a head out by its colours (GrabCut), starting from where the fitted mesh and its landmarks are.

    face: Face with the camera of the picture. image: (H, W, 3) uint8. points: (L, 2) pixels, landmarks, NaN where
    unknown; None for the fitted ones of the face.
    Returns (H, W) bool; what the landmarks enclose where the colours tell nothing. Raises InputError when the face or
    its landmarks are outside, or the picture shows nothing like a head there.
    """
    pixels = mesh_pixels(face, image)
    height, width = image.shape[:2]
    points = Landmarks(face.require_landmarks() if points is None else points, (width, height)).points
    shrink = min(1.0, _SIDE / max(height, width))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA) if shrink < 1 else image
    head = _covered(face, small.shape[0], small.shape[1], shrink)
    enclosed = np.zeros(head.shape, np.uint8)
    outline = np.round(zoomed_pixels(_outline(points), shrink)).astype(np.int32)
    cv2.fillPoly(enclosed, [outline], 1)
    labels = _first_guess(head, enclosed, outline)
    inner = labels == cv2.GC_FGD
    mask = _cut(small, labels, inner, enclosed) if (labels == cv2.GC_BGD).any() and inner.any() else enclosed
    mask = cv2.resize(mask, (width, height), interpolation=cv2.INTER_LINEAR) > 0
    if not (mask & pixels).any():
        raise InputError("expected the head where the face was fitted, found none there")
    return mask


def _outline(points: np.ndarray) -> np.ndarray:
    """(N, 2) pixels around the face: its outline, or where some of that is unknown the hull of all landmarks (L, 2)."""
    given = np.isfinite(points).all(1)
    outline = list(OUTLINE)
    return points[outline] if given[outline].all() else cv2.convexHull(points[given].astype(np.float32))[:, 0]


def _covered(face: Face, height: int, width: int, zoom: float = 1.0) -> np.ndarray:
    """(height, width) bool: pixels that the mesh covers in the picture, made that much larger."""
    placed = face.require_camera().zoomed(zoom).place(face.vertices)
    return covered_pixels(placed, face.faces, width, height)


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
