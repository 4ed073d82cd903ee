"""Which pixels of a picture show the head that was fitted to it."""

import numpy as np

from caricli.errors import InputError
from caricli.render.mask_face import mask_face
from caricli.render.rasterise import rasterise
from caricli.structures import Face

_LEAST = 1e-4
"""Share of a picture that its face fills at least; with less it is of another picture."""


def mesh_pixels(face: Face, image: np.ndarray) -> np.ndarray:
    """(H, W) bool: pixels that the mesh of a face covers.

    face: Face with the camera of the picture. image: (H, W, 3) uint8.
    Raises InputError when the face is outside.
    """
    placed = face.require_camera().place(face.vertices)
    pixels = rasterise(placed, face.faces, image.shape[1], image.shape[0]).face >= 0
    if pixels.mean() < _LEAST:
        raise InputError("expected the picture that the face was fitted to, found it outside")
    return pixels


def mask_head(face: Face, image: np.ndarray, points: np.ndarray | None = None) -> np.ndarray:
    """(H, W) bool: the head in a picture, cut out by its colours.

    face: Face with the camera of the picture. image: (H, W, 3) uint8. points: (L, 2) pixels, landmarks, NaN where
    unknown; None for the fitted ones of the face.
    Raises InputError when the face is outside, or the picture shows nothing like a head there.
    """
    pixels = mesh_pixels(face, image)
    placed = face.require_camera().place(face.vertices)
    mask = mask_face(image, placed, face.faces, face.require_landmarks() if points is None else points)
    if not (mask & pixels).any():
        raise InputError("expected the head where the face was fitted, found none there")
    return mask
