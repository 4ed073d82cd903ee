"""How far the colours of a textured head are from its picture."""

import numpy as np

from caricli.errors import InputError
from caricli.methods.texture.estimate_light import Light
from caricli.render.textured_colours import textured_colours
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Face, Rig


def photometric_error(rig: Rig, face: Face, image: np.ndarray, mask: np.ndarray, light: Light | None = None) -> float:
    """Mean difference of colour between a rendering and the picture where both show the head, of full scale.

    rig: Rig of the textured head without eyeballs. face: Face that it is made of, with the camera of the picture.
    image: (H, W, 3) uint8. mask: (H, W) bool, the head in it. light: Light that was taken out of the texture, and in
    which it is seen again; None for none.
    Raises InputError where the head is nowhere in its mask.
    """
    height, width = image.shape[:2]
    placed = face.require_camera().place(face.vertices)
    raster = rasterise(placed, rig.faces, width, height)
    again = textured_colours(rig, placed, width, height, raster=raster)
    both = mask & (raster.face >= 0)
    if not both.any():
        raise InputError("expected a mask that shows skin of the head, found none of it there")
    if light is not None:
        shade = light.shade_mesh(face.vertices, face.faces)[rig.faces[raster.face[both]]]
        again[both] = np.minimum(again[both] * np.einsum("nk,nkc->nc", raster.barycentric[both], shade), 255)
    return float(np.abs(np.round(again[both]) - image[both]).mean() / 255)
