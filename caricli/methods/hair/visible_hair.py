"""What a camera sees of hair on a head."""

import igl
import numpy as np

from caricli.geometry.join_meshes import join_meshes
from caricli.render.visibility.rasterise import Raster, rasterise
from caricli.structures import Camera, Hair, Mesh


def union_share(first: np.ndarray, second: np.ndarray) -> float:
    """Intersection over union of two masks."""
    return float((first & second).sum() / max((first | second).sum(), 1))


def visible_hair(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: the pixels of a picture of a shape where hair is in front of the head."""
    return seen_faces(head, hair, camera, shape) >= 0


def seen_faces(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, int]) -> np.ndarray:
    """(H, W): which triangle of hair is in front in each pixel of a picture of a shape, below zero for none."""
    return raster_hair(head, hair, camera, shape)[1].face - len(head.faces)


def raster_hair(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, ...]) -> tuple[Mesh, Raster]:
    """Head and hair as one mesh, and the Raster of a picture of a shape."""
    both = join_meshes([head, hair.shell])
    return both, rasterise(camera.place(both.vertices), both.faces, shape[1], shape[0])


def facing(shell: Mesh, camera: Camera) -> np.ndarray:
    """(V,) cosines between a shell and the view."""
    # Vertices of nothing but triangles without area have no normal.
    cosines: np.ndarray = -np.nan_to_num(igl.per_vertex_normals(shell.vertices, shell.faces)) @ camera.rotation[2]
    return cosines
