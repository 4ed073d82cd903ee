"""Where a picture of a mesh shows some of its vertices."""

import numpy as np

from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Mesh


def vertex_pixels(mesh: Mesh, vertices: np.ndarray, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: pixels of triangles with a corner among vertices (V,) bool. size: (W, H) of the picture, pixels."""
    raster = rasterise(camera.place(mesh.vertices), mesh.faces, *size)
    among = vertices[mesh.faces].any(axis=1)
    return (raster.face >= 0) & among[raster.face]
