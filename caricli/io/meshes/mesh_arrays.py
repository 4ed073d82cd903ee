"""A mesh as the named arrays of an NPZ file."""

import numpy as np

from caricli.errors import InputError
from caricli.structures import Mesh

MESH_DTYPES = {"faces": np.int32, "polygons": np.int32, "uvs": np.float64, "uv_polygons": np.int32}
"""Types of the arrays beside the vertices, as they are stored."""


def mesh_to_arrays(mesh: Mesh) -> dict[str, np.ndarray]:
    """The arrays of a mesh beside its vertices; polygons only where the faces do not say all."""
    arrays = {"faces": mesh.faces}
    if not mesh.is_plain:
        arrays["polygons"] = mesh.polygons
    if mesh.uvs is not None and mesh.uv_polygons is not None:
        arrays |= {"uvs": mesh.uvs, "uv_polygons": mesh.uv_polygons}
    return arrays


def mesh_from_arrays(arrays: dict[str, np.ndarray], vertices_key: str) -> Mesh:
    """The mesh of the arrays that ``mesh_to_arrays`` made and its vertices.

    vertices_key: the name of the vertices among the arrays, and in messages.
    Raises InputError when they are no mesh, or the faces are not the triangles of the polygons.
    """
    faces = arrays["faces"]
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
        raise InputError(f"faces: expected (F,3) with F from 1, found {faces.shape}")
    if "polygons" not in arrays and ("uvs" in arrays or "uv_polygons" in arrays):
        raise InputError("polygons: expected them beside the UVs, found none")
    vertices = arrays[vertices_key]
    if "polygons" not in arrays:
        return _triangles(vertices, faces, vertices_key)
    try:
        mesh = Mesh(vertices, arrays["polygons"], arrays.get("uvs"), arrays.get("uv_polygons"))
    except InputError as error:
        raise InputError(str(error).replace("vertices:", f"{vertices_key}:")) from error
    if not np.array_equal(mesh.faces, faces):
        _triangles(vertices, faces, vertices_key)  # what is wrong with the faces by themselves says more
        raise InputError("faces: expected the triangles of the polygons, found others")
    return mesh


def _triangles(vertices: np.ndarray, faces: np.ndarray, vertices_key: str) -> Mesh:
    try:
        return Mesh(vertices, faces)
    except InputError as error:
        message = str(error).replace("vertices:", f"{vertices_key}:")
        raise InputError(message.replace("polygons:", "faces:")) from error
