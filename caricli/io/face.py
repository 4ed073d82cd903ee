"""Faces between stages: NPZ by schema, or the geometry of a mesh file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import content_kind, read_start
from caricli.io.meshes.mesh import is_mesh_file, read_mesh
from caricli.io.meshes.mesh_arrays import mesh_from_arrays, mesh_to_arrays
from caricli.io.npz import read_npz, take_texts, write_npz
from caricli.io.worn import PictureNames, plain_name, read_pictures, write_pictures
from caricli.limits import MAX_VERTICES
from caricli.structures import Camera, Face, Hair, Mesh
from caricli.structures.frame import AXES, UNITS
from caricli.structures.mesh import topology_id
from caricli.structures.pictures import PICTURED

SCHEMA = "caricli.face/1"
_KIND = "a face (NPZ) or a mesh (OBJ, PLY, STL, GLB, glTF)"
_START = 256  # bytes that tell one kind of file from another

_PICTURES = [f"{name}_picture" for name in PICTURED.values()]
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
    "materials": np.int32,
    "teeth": np.float32,
    "hair_vertices": np.float32,
    "hair_polygons": np.int32,
    "hair_uvs": np.float64,
    "hair_uv_polygons": np.int32,
    "hair_roots": np.int32,
    "hair_weights": np.float32,
    **dict.fromkeys(_PICTURES, np.str_),
}
_OWN = ("landmarks", "latent", "residual", "model_id")
_TEXTS = {"schema": SCHEMA, "units": UNITS, "axes": AXES}
_HAIR = ("hair_vertices", "hair_polygons", "hair_uvs", "hair_uv_polygons", "hair_roots", "hair_weights")
_CAMERA = ("camera_scale", "camera_rotation", "camera_translation")


def read_face(path: str | Path) -> Face:
    """Read a face: an NPZ with the pictures that it names, or the mesh of a file that ``read_mesh`` reads.

    Floats come as float64.
    Raises InputError when the file is malformed, a shape, unit, axis or schema differs, a value is not finite, an
    index is out of range, topology_id does not match the faces, or a picture is not beside the file.
    """
    if is_mesh_file(path):
        return Face(read_mesh(path))
    _check_kind(path)
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
        names = _names(values)
        face = replace(_face(values), pictures=read_pictures(Path(path), names))
        # Files of before do not count loose vertices.
        if topology is None or str(topology) not in (face.mesh.topology_id, topology_id(face.faces)):
            raise InputError("expected a topology_id that matches the faces, found another or none")
        return face


def _check_kind(path: str | Path) -> None:
    """Refuse what neither its name nor its content says to be a face."""
    start = read_start(path, _START, _KIND)
    if Path(path).suffix.lower() != ".npz" and content_kind(start) != "a zip archive":
        raise InputError(f"{shown(path)}: expected {_KIND}, found {content_kind(start) or 'another kind of file'}")


def read_picture_names(path: str | Path) -> PictureNames:
    """The pictures that a face NPZ names, whether they are there or not. Raises InputError."""
    arrays = read_npz(path)
    with naming(path):
        return _names({key: _value(key, arrays[key]) for key in _PICTURES if key in arrays})


def write_face(path: str | Path, face: Face, names: PictureNames | None = None) -> None:
    """Write a face NPZ; what is None is absent; vertices, latent and residual are stored in float32.

    names: of pictures that are beside it already; without them the face's are written, see ``write_pictures``.
    Raises OutputError when the file cannot be written.
    """
    mesh = face.mesh
    camera = face.camera
    values: dict = {"vertices": mesh.vertices} | mesh_to_arrays(mesh)
    values |= {key: getattr(face, key) for key in (*_OWN, "materials", "teeth")}
    names = write_pictures(Path(path), face.pictures) if names is None else names
    values |= dict(zip(_PICTURES, names, strict=True))
    values |= _hair_arrays(face.hair)
    if camera is not None:
        values |= dict(zip(_CAMERA, [camera.scale, camera.rotation, camera.translation], strict=True))
    arrays = {key: np.array(text) for key, text in (_TEXTS | {"topology_id": mesh.topology_id}).items()}
    for key, stored in _STORED.items():
        if values.get(key) is not None:
            arrays[key] = np.asarray(values[key], stored)
    write_npz(path, arrays)


def _names(values: dict) -> PictureNames:
    """The names of pictures, plain ones, taken out of values by key."""
    return PictureNames(*(None if key not in values else plain_name(values.pop(key)) for key in _PICTURES))


def _face(values: dict) -> Face:
    """The Face of values by key, vertices and faces among them."""
    mesh = mesh_from_arrays(values, "vertices")
    given = [key for key in _CAMERA if key in values]
    if given and len(given) < len(_CAMERA):
        raise InputError(f"camera: expected {', '.join(_CAMERA)}, found only {', '.join(given)}")
    camera = Camera(*(values[key] for key in _CAMERA)) if given else None
    others: dict[str, Any] = {key: values.get(key) for key in (*_OWN, "materials", "teeth")}
    return Face(mesh, camera, hair=_hair(values), **others)


def _hair_arrays(hair: Hair | None) -> dict[str, np.ndarray | None]:
    if hair is None:
        return {}
    shell = [hair.shell.vertices, hair.shell.polygons, hair.shell.uvs, hair.shell.uv_polygons]
    return dict(zip(_HAIR, [*shell, hair.roots, hair.weights], strict=True))


def _hair(values: dict) -> Hair | None:
    """The Hair of values by key, or None."""
    given = [key for key in _HAIR if key in values]
    if not given:
        return None
    if len(given) < len(_HAIR):
        raise InputError(f"hair: expected {', '.join(_HAIR)}, found only {', '.join(given)}")
    vertices, polygons, uvs, uv_polygons, roots, weights = (values[key] for key in _HAIR)
    try:
        return Hair(Mesh(vertices, polygons, uvs, uv_polygons), roots, weights)
    except InputError as error:
        raise InputError(f"hair: {error}") from error


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
