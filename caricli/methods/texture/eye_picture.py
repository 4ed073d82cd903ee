"""The picture on the eyeballs of a face, as its own picture shows its eyes."""

import numpy as np

from caricli.methods.rig.add_eyeballs import TEXTURE
from caricli.render.eyes.eye_colours import eye_colours
from caricli.render.eyes.iris_radius import iris_radius
from caricli.render.eyes.paint_eye import IRIS, paint_eye
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.structures import Face
from caricli.template.annotation import Annotation

_SMALLEST, _LARGEST = 0.7 * IRIS, 1.5 * IRIS  # whatever a picture tells


def eye_picture(
    face: Face, points: np.ndarray, annotation: Annotation, image: np.ndarray, generator: np.random.Generator
) -> np.ndarray:
    """Paint an eye in the colours of those in a picture, its iris as far as they tell it as large as theirs.

    face: Face with camera. points: (L, 2) its landmarks, pixels, NaN where an eye is not seen. annotation: of its
    topology. image: (H, W, 3) uint8. generator: of the fibres of the iris.
    Returns (TEXTURE, TEXTURE, 3) uint8 sRGB.
    """
    iris, white = eye_colours(image, points)
    radii = [radius for _, radius in place_eyeballs(face.mesh, annotation)]
    reach = IRIS
    if radii:
        pixels, explained = iris_radius(image, points)
        sine = min(pixels / (face.require_camera().scale * float(np.mean(radii))), 1)
        # On generated faces the square of what is explained is how far it helps to believe it.
        reach += explained**2 * (float(np.arcsin(sine)) / (2 * np.pi) - IRIS)
    return paint_eye(TEXTURE, generator, iris, white, min(max(reach, _SMALLEST), _LARGEST))
