"""How far the colours of a textured head are from its picture."""

import numpy as np

from caricli.render.rasterise import rasterise
from caricli.render.render_textured import render_textured
from caricli.structures import Face, Rig


def photometric_error(rig: Rig, face: Face, image: np.ndarray, mask: np.ndarray) -> float:
    """Mean difference of colour between a rendering and the picture where both show the head, of full scale.

    rig: Rig of the textured head without eyeballs. face: Face that it is made of, with the camera of the picture.
    image: (H, W, 3) uint8. mask: (H, W) bool, the head in it.
    """
    height, width = image.shape[:2]
    placed = face.require_camera().place(face.vertices)
    again = render_textured(rig, placed, width, height)
    both = mask & (rasterise(placed, rig.faces, width, height).face >= 0)
    return float(np.abs(again.astype(float) - image)[both].mean() / 255)
