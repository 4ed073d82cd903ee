"""Which point of the surface every texel of a picture shows."""

import numpy as np

from caricli.errors import InputError
from caricli.render.visibility.nearest_pixel import nearest_index
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Mesh


def uv_map(mesh: Mesh, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the triangle under the centre of every texel.

    mesh: Mesh with UVs. size: texels, width and height; row 0 is the top one.
    Returns (face (size, size) int32, -1 where no triangle lies, and barycentric (size, size, 3) float32, the weights of
    its corners, zero there). Raises InputError when the mesh has no UVs.
    """
    if mesh.uvs is None:
        raise InputError("a map of texels needs a mesh with UVs, found one without")
    uvs = mesh.uvs
    places = np.column_stack([uvs[:, 0], 1 - uvs[:, 1], np.zeros(len(uvs))]) * size - [0.5, 0.5, 0]
    raster = rasterise(places, mesh.uv_faces, size, size)
    return raster.face, raster.barycentric


def pad_texture(image: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Continue a picture beyond the borders of its UV islands, so that filters and mip levels never mix others in.

    image: (H, W, ...). covered: (H, W) bool, texels that hold a colour; the others take the nearest of theirs.
    Returns an array like ``image``, which it equals where nothing is covered at all.
    """
    if not covered.any():
        return image.copy()
    return image.reshape(-1, *image.shape[2:]).take(nearest_index(covered), 0)
