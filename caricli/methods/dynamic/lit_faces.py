"""Generated faces as textures in light: what styles are learnt on, and what style pictures are painted of."""

from dataclasses import replace

import numpy as np

from caricli.data.appearance import Appearance
from caricli.data.texture_painter import TexturePainter
from caricli.methods.pictures.light import Sky
from caricli.methods.texture.estimate_light import harmonics
from caricli.render.pixels.levels import to_bytes
from caricli.render.pixels.srgb import to_linear, to_srgb
from caricli.render.sky import DIRECTIONS
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.uv_map import pad_texture
from caricli.template.template import Template

MARGIN = 0.02
"""Around the face in its picture, of the larger side."""

_BANDS = np.repeat([1, 2 / 3, 1 / 4], [1, 3, 5])
"""Shares of the harmonics of light that a dull surface sends back, by their order."""


class LitFaces:
    """Paints textures of the face of a template as light shows them."""

    def __init__(self, template: Template, size: int) -> None:
        """template: with UVs. size: texels, width and height. Raises InputError when there are no UVs."""
        self.painter = TexturePainter(_face_alone(template), size)
        places = self.painter.painter.weights
        normals = places @ smooth_normals(template.vertices, template.faces)
        self.normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)

    def draw(self, appearance: Appearance, sky: Sky) -> np.ndarray:
        """Paint an Appearance under a Sky. Returns (S, S, 3) uint8 sRGB, the top row first."""
        albedo = self.painter.painter.draw(appearance)
        light = np.maximum((harmonics(self.normals * [1, -1, -1]) * _BANDS) @ sky.harmonics(DIRECTIONS), 0)
        light = light / max(float(light.mean()), 1e-6)  # so bright that white is 1 in the mean
        covered = self.painter.covered
        picture = np.zeros((*covered.shape, 3), np.uint8)
        picture[covered] = to_bytes(to_srgb(to_linear(albedo) * light))
        return pad_texture(picture, covered)


def _face_alone(template: Template) -> Template:
    """A template of whose UVs the face fills the picture; the rest lies outside."""
    if template.uvs is None:
        return template
    inside = template.mask("face")[template.faces].all(1)
    uvs = template.uvs[template.uv_faces[inside].ravel()]
    low = uvs.min(0)
    high = uvs.max(0)
    side = (1 + 2 * MARGIN) * float((high - low).max())
    return replace(template, uvs=(template.uvs - (low + high) / 2) / side + 0.5)
