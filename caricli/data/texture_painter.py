"""Random albedos as pictures in the UVs of a template."""

import numpy as np

from caricli.data.albedo import AlbedoPainter
from caricli.data.appearance import Appearance
from caricli.errors import InputError
from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.pixels.levels import to_bytes
from caricli.render.visibility.corner_mix import corner_mix
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.template.template import Template


class TexturePainter:
    """Paints pictures of one template and size."""

    def __init__(self, template: Template, size: int) -> None:
        """template: with UVs. size: texels, width and height. Raises InputError when there are no UVs."""
        if template.uvs is None:
            raise InputError("an albedo needs a template with UVs, found one without")
        face, weights = uv_map(template, size)
        self.covered = face >= 0
        matrix = corner_mix(template.faces[face[self.covered]], weights[self.covered], len(template.vertices))
        area = np.linalg.norm(triangle_normals(template.vertices, template.faces), axis=1).sum() / 2
        self.painter = AlbedoPainter(template, matrix, float(np.sqrt(area / matrix.shape[0])))

    def draw(self, appearance: Appearance) -> np.ndarray:
        """Paint an Appearance. Returns (S, S, 3) uint8 sRGB, the top row first."""
        picture = np.zeros((*self.covered.shape, 3), np.uint8)
        picture[self.covered] = to_bytes(self.painter.draw(appearance))
        return pad_texture(picture, self.covered)
