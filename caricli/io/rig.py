"""Rigs and blendshapes between stages: a neutral face and named displacements, NPZ by schema."""

from dataclasses import dataclass, fields

import numpy as np

from caricli.errors import InputError, OutputError
from caricli.io.face import AXES, UNITS, Face, face_problem
from caricli.io.files import shown
from caricli.limits import MAX_SHAPES
from caricli.io.npz import read_npz, text_of, write_npz

SCHEMA = "caricli.rig/1"

SKIN, EYES = 0, 1
"""What a polygon is made of."""

_TEXTS = {"schema": SCHEMA, "units": UNITS, "axes": AXES}
_STORED = {
    "names": np.str_,
    "neutral": np.float32,
    "deltas": np.float32,
    "faces": np.int32,
    "polygons": np.int32,
    "uvs": np.float64,
    "uv_polygons": np.int32,
    "materials": np.int32,
    "texture": np.uint8,
    "eye_texture": np.uint8,
    "normal_deltas": np.float32,
}
_REQUIRED = ("names", "neutral", "deltas", "faces")


@dataclass(frozen=True, eq=False)
class Rig:
    """A face with named expressions: ``neutral + sum_k weight_k deltas_k`` (portrait paper, equation 13).

    names (K,), distinct, none for a head that keeps still; neutral (V,3) float32, metres, +y up, +z front; deltas
    (K,V,3) float32, metres; faces (F,3) int32; polygons (P,N) int32 padded with -1, uvs (T,2) float64, origin bottom
    left, and uv_polygons (P,N), as in ObjMesh; materials (P,) int32, SKIN or EYES, of the polygons; texture and
    eye_texture (H,W,3) uint8 sRGB, the top row first, of either material; normal_deltas (K,N,3) float32, metres, what
    the same expressions do to a normal face of N vertices (expressions paper, equation 19). What is None is absent.
    """

    names: tuple
    neutral: np.ndarray
    deltas: np.ndarray
    faces: np.ndarray
    polygons: np.ndarray | None = None
    uvs: np.ndarray | None = None
    uv_polygons: np.ndarray | None = None
    materials: np.ndarray | None = None
    texture: np.ndarray | None = None
    eye_texture: np.ndarray | None = None
    normal_deltas: np.ndarray | None = None


def read_rig(path):
    """Read a rig.

    Parameters: path of a file that `write_rig` wrote.
    Returns: Rig.
    Raises: InputError when the file is malformed, a shape, unit, axis or schema differs, names repeat, a value is not
    finite, or an index is out of range.
    """
    arrays = read_npz(path)
    for key, expected in _TEXTS.items():
        if text_of(arrays.pop(key, None)) != expected:
            raise InputError(f"{shown(path)}: expected a rig with {key} {expected!r}, found another or none")
    unknown = set(arrays) - set(_STORED)
    if unknown:
        raise InputError(f"{shown(path)}: expected the arrays of a rig, found {shown(min(unknown), 60)!r}")
    for key in _REQUIRED:
        if key not in arrays:
            raise InputError(f"{shown(path)}: expected a rig with {key}, found none")
    for key, array in arrays.items():
        stored = np.dtype(_STORED[key])
        # A whole number that does not fit would come out as another one.
        if array.dtype.kind != stored.kind or (stored.kind in "iu" and (array.astype(stored) != array).any()):
            raise InputError(f"{shown(path)}: {key}: expected {stored.name}, found {array.dtype}")
    # What single precision cannot hold becomes infinite, which is refused below.
    with np.errstate(over="ignore"):
        values = {key: a if a.dtype.kind == "U" else a.astype(_STORED[key]) for key, a in arrays.items()}
    if values["names"].ndim == 1:
        values["names"] = tuple(values["names"].tolist())
    rig = Rig(**values)
    problem = rig_problem(rig)
    if problem:
        raise InputError(f"{shown(path)}: {problem}")
    return rig


def write_rig(path, rig):
    """Write a rig; what is None is absent; the same rig gives the same bytes.

    Parameters: path; rig, Rig.
    Raises: OutputError when the rig could not be read back or the file cannot be written.
    """
    problem = rig_problem(rig)
    if problem:
        raise OutputError(f"{shown(path)}: {problem}")
    arrays = {key: np.array(text) for key, text in _TEXTS.items()}
    values = {field.name: getattr(rig, field.name) for field in fields(rig)}
    write_npz(path, arrays | {key: np.asarray(v, _STORED[key]) for key, v in values.items() if v is not None})


def rig_problem(rig):
    """Return what is wrong with a rig as "key: expected ..., found ...", or None."""
    names = rig.names
    sound = isinstance(names, tuple) and all(isinstance(n, str) and n for n in names)
    if not sound or len(names) > MAX_SHAPES or len(set(names)) < len(names):
        return f"names: expected at most {MAX_SHAPES} distinct names, found {shown(names, 60)}"
    neutral, deltas = np.asarray(rig.neutral), np.asarray(rig.deltas)
    problem = face_problem(Face(neutral, rig.faces, None, polygons=rig.polygons, uvs=rig.uvs,
                                uv_polygons=rig.uv_polygons))  # fmt: skip
    if problem:
        return problem.replace("vertices:", "neutral:")
    if deltas.shape != (len(names), *neutral.shape):
        return f"deltas: expected the shape {(len(names), *neutral.shape)}, found {deltas.shape}"
    if not np.isfinite(deltas).all():
        return "deltas: expected finite numbers, found others"
    if rig.normal_deltas is not None:
        normal = np.asarray(rig.normal_deltas)
        if normal.ndim != 3 or (len(normal), normal.shape[2]) != (len(names), 3) or not np.isfinite(normal).all():
            return f"normal_deltas: expected {len(names)} finite displacements of a face, found {normal.shape}"
    if rig.materials is not None:
        materials = np.asarray(rig.materials)
        fits = rig.polygons is not None and materials.shape == (len(rig.polygons),)
        if not fits or not np.isin(materials, (SKIN, EYES)).all():
            return f"materials: expected {SKIN} or {EYES} for every polygon, found others"
    for key in ("texture", "eye_texture"):
        image = getattr(rig, key)
        if image is None:
            continue
        image = np.asarray(image)
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
            return f"{key}: expected (H,W,3) uint8, found {image.shape} {image.dtype}"
    return None
