"""Faces between stages: NPZ by schema, or the geometry of an OBJ."""

import hashlib
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError
from caricli.io.files import shown
from caricli.limits import MAX_COORDINATE, MAX_CORNERS, MAX_POLYGON_CORNERS, MAX_POLYGONS, MAX_VERTICES
from caricli.io.npz import read_npz, text_of, write_npz
from caricli.io.obj import padding_is_last, read_obj, repeats

SCHEMA = "caricli.face/1"
UNITS = "m"
AXES = "+y up, +z front"

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


@dataclass(frozen=True, eq=False)
class Face:
    """One face.

    vertices (V,3) float64, metres, +y up, +z front; faces (F,3) int32; latent (D,) whatever its model means; residual
    (V,9), feature space; camera_scale, pixels per metre; camera_rotation (3,3), a proper rotation to x right, y down,
    z into the picture; camera_translation (2,), pixels; landmarks (L,2), fitted 2D points, pixels; model_id, text;
    polygons (P,N) int32 padded with -1, uvs (T,2) and uv_polygons (P,N), as in ObjMesh. None is absent.
    """

    vertices: np.ndarray
    faces: np.ndarray
    latent: np.ndarray | None = None
    residual: np.ndarray | None = None
    camera_scale: float | None = None
    camera_rotation: np.ndarray | None = None
    camera_translation: np.ndarray | None = None
    landmarks: np.ndarray | None = None
    model_id: str | None = None
    polygons: np.ndarray | None = None
    uvs: np.ndarray | None = None
    uv_polygons: np.ndarray | None = None


def topology_id(faces):
    """Return the SHA-256, as hexadecimal digits, of faces (F,3) as little-endian int32 in C order."""
    return hashlib.sha256(np.ascontiguousarray(faces, "<i4").tobytes()).hexdigest()


def read_face(path):
    """Read a face.

    Parameters: path of a face NPZ, or of an OBJ, whose polygons become fans of triangles.
    Returns: Face, floats as float64.
    Raises: InputError when the file is malformed, a shape, unit, axis or schema differs, a value is not finite, an
    index is out of range, or topology_id does not match the faces.
    """
    if Path(path).suffix.lower() == ".obj":
        mesh = read_obj(path)
        return Face(
            mesh.vertices,
            fans(mesh.polygons),
            polygons=mesh.polygons,
            uvs=mesh.uvs,
            uv_polygons=mesh.uv_polygons,
        )
    arrays = read_npz(path)
    for key, expected in _TEXTS.items():
        if text_of(arrays.pop(key, None)) != expected:
            raise InputError(f"{shown(path)}: expected a face with {key} {expected!r}, found another or none")
    topology = text_of(arrays.pop("topology_id", None))
    unknown = set(arrays) - set(_STORED)
    if unknown:
        raise InputError(f"{shown(path)}: expected the arrays of a face, found {shown(min(unknown), 60)!r}")
    values = {key: _value(key, array, path) for key, array in arrays.items()}
    for key in ("vertices", "faces"):
        if key not in values:
            raise InputError(f"{shown(path)}: expected a face with {key}, found none")
    face = Face(**values)
    problem = face_problem(face)
    if problem:
        raise InputError(f"{shown(path)}: {problem}")
    if topology != topology_id(face.faces):
        raise InputError(f"{shown(path)}: expected a topology_id that matches the faces, found another or none")
    return face


def write_face(path, face):
    """Write a face NPZ; what is None is absent; vertices, latent and residual are stored in float32.

    Parameters: path; face, Face.
    Raises: OutputError when the face could not be read back or the file cannot be written.
    """
    problem = face_problem(face)
    if problem:
        raise OutputError(f"{shown(path)}: {problem}")
    arrays = {key: np.array(text) for key, text in _TEXTS.items()}
    arrays["topology_id"] = np.array(topology_id(face.faces))
    for field in fields(face):
        value = getattr(face, field.name)
        if value is not None:
            arrays[field.name] = np.asarray(value, _STORED[field.name])
    write_npz(path, arrays)


def fans(polygons):
    """Split polygons (P,N), padded with -1, into triangle fans (F,3) around their first corner, in their order."""
    # Faces need triangles already here, and io does not import geometry.
    triangles = np.stack(
        [np.repeat(polygons[:, :1], polygons.shape[1] - 2, 1), polygons[:, 1:-1], polygons[:, 2:]], axis=2
    )
    return triangles[triangles[:, :, 2] >= 0]


def _value(key, array, path):
    stored = np.dtype(_STORED[key])
    if stored.kind == "U":
        text = text_of(array)
        if not text:
            raise InputError(f"{shown(path)}: {key}: expected text, found {array.dtype} {array.shape}")
        return text
    kinds = "iu" if stored.kind == "i" else "iuf"
    if array.dtype.kind not in kinds:
        raise InputError(f"{shown(path)}: {key}: expected {stored}, found {array.dtype}")
    if stored.kind == "i":
        if array.size and (array.min() < -1 or array.max() > MAX_VERTICES):
            raise InputError(f"{shown(path)}: {key}: expected indices from 0, found {array.min()} to {array.max()}")
        return array.astype(np.int32)
    array = array.astype(np.float64)
    return float(array) if key == "camera_scale" and array.ndim == 0 else array


def face_problem(face):
    """Return what is wrong with a face as "key: expected ..., found ...", or None."""
    vertices, faces = np.asarray(face.vertices), np.asarray(face.faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not 3 <= len(vertices) <= MAX_VERTICES:
        return f"vertices: expected (V,3) with V from 3 to {MAX_VERTICES}, found {vertices.shape}"
    if faces.ndim != 2 or faces.shape[1] != 3 or not 1 <= len(faces) <= MAX_POLYGONS * 2:
        return f"faces: expected (F,3) with F from 1, found {faces.shape}"
    return (
        _coordinate_problem("vertices", vertices)
        or _index_problem("faces", faces, len(vertices))
        or _polygon_problem(face, len(vertices))
        or _extra_problem(face, len(vertices))
    )


def _polygon_problem(face, vertex_count):
    if face.polygons is None:
        if face.uvs is not None or face.uv_polygons is not None:
            return "polygons: expected them beside the UVs, found none"
        return None
    polygons = np.asarray(face.polygons)
    sound = polygons.ndim == 2 and 3 <= polygons.shape[1] <= MAX_POLYGON_CORNERS
    if not sound or not 1 <= polygons.size <= MAX_CORNERS:
        return f"polygons: expected (P,N) with N from 3 to {MAX_POLYGON_CORNERS}, found {polygons.shape}"
    problem = _index_problem("polygons", polygons, vertex_count)
    if problem or (face.uvs is None and face.uv_polygons is None):
        return problem
    if face.uvs is None or face.uv_polygons is None:
        return "uvs: expected them together with uv_polygons, found only one"
    uvs, uv_polygons = np.asarray(face.uvs), np.asarray(face.uv_polygons)
    if uvs.ndim != 2 or uvs.shape[1] != 2 or len(uvs) > MAX_VERTICES:
        return f"uvs: expected (T,2), found {uvs.shape}"
    if uv_polygons.shape != polygons.shape or ((uv_polygons >= 0) != (polygons >= 0)).any():
        return "uv_polygons: expected an index for every corner of polygons, found fewer or more"
    return _coordinate_problem("uvs", uvs) or _index_problem("uv_polygons", uv_polygons, len(uvs), distinct=False)


def _extra_problem(face, vertex_count):
    shapes = {
        "latent": (None,),
        "residual": (vertex_count, 9),
        "camera_scale": (),
        "camera_rotation": (3, 3),
        "camera_translation": (2,),
        "landmarks": (None, 2),
    }
    for key, shape in shapes.items():
        value = getattr(face, key)
        if value is None:
            continue
        value = np.asarray(value)
        matches = value.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, value.shape, strict=True))
        if not matches or 0 in value.shape:
            expected = ",".join("*" if n is None else str(n) for n in shape)
            return f"{key}: expected the shape ({expected}), found {value.shape}"
        if not (np.abs(value) <= np.finfo(np.float32).max).all():
            return f"{key}: expected finite numbers, found others"
    if face.camera_scale is not None and not face.camera_scale > 0:
        return f"camera_scale: expected more than 0, found {face.camera_scale}"
    if face.camera_rotation is not None:
        rotation = np.asarray(face.camera_rotation, np.float64)
        far = not (np.abs(rotation) <= 1.001).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-4
        if far or np.linalg.det(rotation) < 0:
            return "camera_rotation: expected a proper rotation, found another matrix"
    return None


def _coordinate_problem(key, points):
    if not (np.abs(points) <= MAX_COORDINATE).all():
        return f"{key}: expected finite coordinates of at most {MAX_COORDINATE:g}, found others"
    return None


def _index_problem(key, indices, count, distinct=True):
    if not padding_is_last(indices):
        return f"{key}: expected rows of at least 3 indices followed by -1 only, found others"
    if indices.max() >= count:
        return f"{key}: expected indices below {count}, found {indices.max()}"
    if distinct and repeats(indices).any():
        return f"{key}: expected distinct corners, found one twice in row {int(np.argmax(repeats(indices)))}"
    return None
