"""A textured head from any side, as flat as its texture."""

from collections.abc import Iterable, Sequence

import cv2
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_texture
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import TO_PICTURE, VIEWS, turn_about_y
from caricli.structures import Rig
from caricli.structures.pictures import PICTURED

ANGLES = VIEWS | {"behind": 180.0}
PAPER = 255.0
INSIDE = (46.0, 36.0, 34.0)
"""sRGB of what is seen from inside, through the open neck."""

_FILL = 0.9  # of the picture's side
_SUPER = 2  # times as large it is drawn before it is shrunk
_SHADE = 0.18  # how much darker a surface is that is seen from the side


def draw_textured(rig: Rig, views: Iterable[str], size: int) -> list[np.ndarray]:
    """Draw the neutral face of a textured rig, its colours as they are but for a little darkness where it turns away.

    rig: Rig with UVs and textures. views: keys of ``ANGLES``. size: pixels.
    Returns a list of (size, size, 3) uint8 on white.
    """
    vertices = rig.neutral.astype(float)
    middle = (vertices.min(0) + vertices.max(0)) / 2
    scale = _FILL * size * _SUPER / np.ptp(vertices, axis=0).max()
    pictures = []
    for view in views:
        placed = scale * (vertices - middle) @ (TO_PICTURE @ turn_about_y(ANGLES[view])).T
        placed[:, :2] += size * _SUPER / 2 - 0.5
        picture = render_textured(rig, placed, size * _SUPER, size * _SUPER, _SHADE)
        pictures.append(cv2.resize(picture, (size, size), interpolation=cv2.INTER_AREA))
    return pictures


def render_textured(
    rig: Rig,
    placed: np.ndarray,
    width: int,
    height: int,
    shade: float = 0.0,
    paper: float | np.ndarray | Sequence[float] = PAPER,
) -> np.ndarray:
    """Look up the textures of a rig at every pixel.

    rig: Rig with UVs. placed: (V, 3) its vertices, in pixels and depth, as `rasterise` takes them. width, height:
    pixels. shade: how much darker a surface is that is seen from the side. paper: sRGB, 0 to 255, behind it and where
    there is no picture.
    Returns (height, width, 3) uint8.
    """
    faces = rig.faces
    raster = rasterise(placed, faces, width, height)
    shown = raster.face >= 0
    face = raster.face[shown]
    weights = raster.barycentric[shown].astype(np.float64)
    colours = _looked_up(rig, face, weights, paper)
    if shade:
        normals = np.einsum("nk,nkc->nc", weights, smooth_normals(placed, faces)[faces[face]])
        facing = np.abs(normals[:, 2]) / np.maximum(np.linalg.norm(normals, axis=1), 1e-9)
        colours *= 1 - shade * (1 - facing[:, None])
    # The picture is on the outside; the neck is open.
    colours[triangle_normals(placed, faces)[face, 2] > 0] = INSIDE
    image = np.full((height, width, 3), paper)
    image[shown] = colours
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def _looked_up(
    rig: Rig, face: np.ndarray, weights: np.ndarray, paper: float | np.ndarray | Sequence[float]
) -> np.ndarray:
    """Colours (N, 3) of places in triangles (N,) with barycentric weights (N, 3)."""
    assert rig.mesh.uvs is not None
    uvs = np.einsum("nk,nkc->nc", weights, rig.mesh.uvs[rig.mesh.uv_faces[face]])
    materials = rig.triangle_materials[face]
    colours = np.full((len(face), 3), paper)
    for material in PICTURED:
        picture = rig.pictures.of(material)
        if picture is not None and (materials == material).any():
            colours[materials == material] = sample_texture(picture, uvs[materials == material])
    return colours
