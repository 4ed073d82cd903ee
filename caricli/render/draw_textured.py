"""A textured head from any side, as flat as its texture."""

import cv2
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_texture
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import VIEWS
from caricli.structures import Material

ANGLES = VIEWS | {"behind": 180.0}
PAPER, INSIDE = 255.0, (46.0, 36.0, 34.0)
_FILL, _SUPER, _SHADE = 0.9, 2, 0.18


def draw_textured(rig, views, size):
    """Draw the neutral face of a textured rig, its colours as they are but for a little darkness where it turns away.

    rig: Rig with UVs and textures. views: keys of ``ANGLES``. size: pixels.
    Returns a list of (size, size, 3) uint8 on white.
    """
    vertices = rig.neutral.astype(float)
    middle = (vertices.min(0) + vertices.max(0)) / 2
    scale = _FILL * size * _SUPER / np.ptp(vertices, axis=0).max()
    pictures = []
    for view in views:
        angle = np.radians(ANGLES[view])
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        placed = scale * (vertices - middle) @ (np.diag([1.0, -1.0, -1.0]) @ turn).T
        placed[:, :2] += size * _SUPER / 2 - 0.5
        picture = render_textured(rig, placed, size * _SUPER, size * _SUPER, _SHADE)
        pictures.append(cv2.resize(picture, (size, size), interpolation=cv2.INTER_AREA))
    return pictures


def render_textured(rig, placed, width, height, shade=0.0, paper=PAPER):
    """Look up the textures of a rig at every pixel.

    rig: Rig with UVs. placed: (V, 3) its vertices, in pixels and depth, as `rasterise` takes them. shade: how much
    darker a surface is that is seen from the side. Returns (height, width, 3) uint8.
    """
    faces = rig.mesh.faces
    raster = rasterise(placed, faces, width, height)
    shown = raster.face >= 0
    face, weights = raster.face[shown], raster.barycentric[shown].astype(np.float64)
    uvs = np.einsum("nk,nkc->nc", weights, rig.mesh.uvs[rig.mesh.uv_faces[face]])
    owner = rig.triangle_materials[face]
    colours = np.full((len(face), 3), paper)
    for material, picture in ((Material.SKIN, rig.texture), (Material.EYE, rig.eye_texture)):
        if picture is not None and (owner == material).any():
            colours[owner == material] = sample_texture(picture, uvs[owner == material])
    if shade:
        normals = np.einsum("nk,nkc->nc", weights, smooth_normals(placed, faces)[faces[face]])
        facing = np.abs(normals[:, 2]) / np.maximum(np.linalg.norm(normals, axis=1), 1e-9)
        colours *= 1 - shade * (1 - facing[:, None])
    # The picture is on the outside; the neck is open.
    colours[triangle_normals(placed, faces)[face, 2] > 0] = INSIDE
    image = np.full((height, width, 3), paper)
    image[shown] = colours
    return np.clip(np.round(image), 0, 255).astype(np.uint8)
