"""The colours of a texture where a picture shows them, without any light: for measuring, not for looking at."""

from collections.abc import Sequence

import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.pixels.sample_texture import sample_texture
from caricli.render.visibility.rasterise import Raster, rasterise
from caricli.structures import Rig
from caricli.structures.pictures import PICTURED

PAPER = 255.0
INSIDE = (46.0, 36.0, 34.0)
"""sRGB of what is seen from inside, through the open neck."""


def textured_colours(
    rig: Rig,
    placed: np.ndarray,
    width: int,
    height: int,
    paper: float | np.ndarray | Sequence[float] = PAPER,
    raster: Raster | None = None,
) -> np.ndarray:
    """Look up the textures of a rig at every pixel.

    rig: Rig with UVs. placed: (V, 3) its vertices, in pixels and depth, as `rasterise` takes them. width, height:
    pixels. paper: sRGB, 0 to 255, behind it and where there is no picture. raster: Raster of what is placed, or None to
    find it.
    Returns (height, width, 3) float64 sRGB, 0 to 255, not rounded.
    """
    faces = rig.faces
    raster = raster or rasterise(placed, faces, width, height)
    shown = raster.face >= 0
    face = raster.face[shown]
    weights = raster.barycentric[shown].astype(np.float64)
    colours = _looked_up(rig, face, weights, paper)
    # The picture is on the outside; the neck is open.
    colours[triangle_normals(placed, faces)[face, 2] > 0] = INSIDE
    image = np.full((height, width, 3), paper, float)
    image[shown] = colours
    return image


def _looked_up(
    rig: Rig, face: np.ndarray, weights: np.ndarray, paper: float | np.ndarray | Sequence[float]
) -> np.ndarray:
    """Colours (N, 3) of places in triangles (N,) with barycentric weights (N, 3)."""
    assert rig.mesh.uvs is not None
    uvs = np.einsum("nk,nkc->nc", weights, rig.mesh.uvs[rig.mesh.uv_faces[face]])
    materials = rig.triangle_materials[face]
    colours = np.full((len(face), 3), paper, float)
    for material in PICTURED:
        picture = rig.pictures.of(material)
        if picture is not None and (materials == material).any():
            colours[materials == material] = sample_texture(picture.astype(np.float32), uvs[materials == material])
    return colours
