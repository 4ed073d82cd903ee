"""Colours of the vertices on a face, as the picture that it wears."""

from dataclasses import replace

import numpy as np

from caricli.methods.parts.close_neck import neck_picture
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Face, Pictures
from caricli.template.template import Template

SIZE = 512
"""Texels of the picture, width and height: the bundled head has a vertex for every few of them."""


def wear_colours(face: Face, template: Template, colours: np.ndarray) -> Face:
    """The face in colours that lie between those of its vertices, and what closes its neck in those at its edge; a face
    without UVs stays as it is.

    template: Template whose polygons and UVs the face has. colours: (V, 3) sRGB from 0 to 1.
    """
    if face.mesh.uvs is None:
        return face
    triangle, weights = uv_map(face.mesh, SIZE)
    covered = triangle >= 0
    shown = (weights[covered][..., None] * colours[face.faces[triangle[covered]]]).sum(1)
    picture = np.zeros((SIZE, SIZE, 3), np.uint8)
    picture[covered] = np.round(255 * np.clip(shown, 0, 1))
    skin = pad_texture(picture, covered)
    return replace(face, pictures=Pictures(skin, bust=neck_picture(template, skin, skin)))
