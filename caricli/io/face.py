"""Faces between stages: NPZ by schema, or the geometry of a mesh file."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.mesh import is_mesh_file, read_mesh
from caricli.io.mesh_arrays import mesh_from_arrays, mesh_to_arrays
from caricli.io.npz import read_npz, take_texts, write_npz
from caricli.limits import MAX_VERTICES
from caricli.structures import Camera, Face

SCHEMA = "caricli.face/1"
UNITS = "m"
AXES = "+y up, +z front"

# In the order in which they are written.
_STORED = {
    "vertices": np.float32,
    "faces": np.int32,
    "latent": np.float32,
    "residual": np.float32,
    "camera_scale": np.float64,
    "camera_rotation": np.float64,
    "camera_translation": np.float64,
    "landmarks": np.float64,
    "model_id": np.str_,
    "polygons": np.int32,
    "uvs": np.float64,
    "uv_polygons": np.int32,
}
_TEXTS = {"schema": SCHEMA, "units": UNITS, "axes": AXES}
_CAMERA = ("camera_scale", "camera_rotation", "camera_translation")


def read_face(path: str | Path) -> Face:
    """Read a face: an NPZ, or the mesh of a file that ``read_mesh`` reads. Floats come as float64.

    Raises InputError when the file is malformed, a shape, unit, axis or schema differs, a value is not finite, an
    index is out of range, or topology_id does not match the faces.
    """
    if is_mesh_file(path):
        return Face(read_mesh(path))
    arrays = read_npz(path)
    with naming(path):
        take_texts(arrays, _TEXTS, "a face")
        topology = arrays.pop("topology_id", None)
        unknown = set(arrays) - set(_STORED)
        if unknown:
            raise InputError(f"expected the arrays of a face, found {shown(min(unknown), 60)!r}")
        values = {key: _value(key, array) for key, array in arrays.items()}
        for key in ("vertices", "faces"):
            if key not in values:
                raise InputError(f"expected a face with {key}, found none")
        face = _face(values)
        if topology is None or str(topology) != face.mesh.topology_id:
            raise InputError("expected a topology_id that matches the faces, found another or none")
        return face


def write_face(path: str | Path, face: Face) -> None:
    """Write a face NPZ; what is None is absent; vertices, latent and residual are stored in float32.

    Raises OutputError when the file cannot be written.
    """
    mesh = face.mesh
    camera = face.camera
    values: dict = {"vertices": mesh.vertices} | mesh_to_arrays(mesh)
    values |= {key: getattr(face, key) for key in ("latent", "residual", "landmarks", "model_id")}
    if camera is not None:
        values |= dict(zip(_CAMERA, [camera.scale, camera.rotation, camera.translation], strict=True))
    arrays = {key: np.array(text) for key, text in (_TEXTS | {"topology_id": mesh.topology_id}).items()}
    for key, stored in _STORED.items():
        if values.get(key) is not None:
            arrays[key] = np.asarray(values[key], stored)
    write_npz(path, arrays)


def _face(values: dict) -> Face:
    """The Face of values by key, vertices and faces among them."""
    mesh = mesh_from_arrays(values, "vertices")
    given = [key for key in _CAMERA if key in values]
    if given and len(given) < len(_CAMERA):
        raise InputError(f"camera: expected {', '.join(_CAMERA)}, found only {', '.join(given)}")
    camera = Camera(*(values[key] for key in _CAMERA)) if given else None
    return Face(mesh, camera, *(values.get(key) for key in ("landmarks", "latent", "residual", "model_id")))


def _value(key: str, array: np.ndarray) -> np.ndarray | str:
    stored = np.dtype(_STORED[key])
    if stored.kind == "U":
        if array.dtype.kind != "U" or array.ndim or not array.item():
            raise InputError(f"{key}: expected text, found {array.dtype} {array.shape}")
        return str(array.item())
    kinds = "iu" if stored.kind == "i" else "iuf"
    if array.dtype.kind not in kinds:
        raise InputError(f"{key}: expected {stored}, found {array.dtype}")
    if stored.kind == "i":
        if array.size and (array.min() < -1 or array.max() > MAX_VERTICES):
            raise InputError(f"{key}: expected indices from 0, found {array.min()} to {array.max()}")
        return array.astype(np.int32)
    return array.astype(np.float64)
