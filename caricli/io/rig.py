"""Rigs and blendshapes between stages: a neutral face and named displacements, NPZ by schema."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.meshes.mesh_arrays import MESH_DTYPES, mesh_from_arrays, mesh_to_arrays
from caricli.io.npz import read_npz, take_texts, write_npz
from caricli.structures import Camera, Depiction, Mood, Pictures, Rig
from caricli.structures.change_atlas import ChangeAtlas
from caricli.structures.frame import AXES, UNITS

SCHEMA = "caricli.rig/1"

_TEXTS = {"schema": SCHEMA, "units": UNITS, "axes": AXES}
_TEXTURES = {"texture": "skin", "eye_texture": "eyes", "hair_texture": "hair", "bust_texture": "bust"}
_CAMERA = ("camera_scale", "camera_rotation", "camera_translation")
# In the order in which they are written.
_STORED = {
    "names": np.str_,
    "neutral": np.float32,
    "deltas": np.float32,
    **MESH_DTYPES,
    "materials": np.int32,
    **dict.fromkeys(_TEXTURES, np.uint8),
    "normal_deltas": np.float32,
    "moods": np.str_,
    "mood_textures": np.uint8,
    **dict.fromkeys(_CAMERA, np.float64),
    "depicted": np.float32,
    "landmarks": np.float64,
    "actions": np.float32,
    "changes": np.uint8,
    "change_layout": np.float64,
}
_REQUIRED = ("names", "neutral", "deltas", "faces")
_LOOKS = ("materials", "normal_deltas", "actions")


def read_rig(path: str | Path) -> Rig:
    """Read a rig that ``write_rig`` wrote.

    Raises InputError when the file is malformed, a shape, unit, axis or schema differs, names repeat, a value is not
    finite, or an index is out of range.
    """
    arrays = read_npz(path)
    with naming(path):
        take_texts(arrays, _TEXTS, "a rig")
        unknown = set(arrays) - set(_STORED)
        if unknown:
            raise InputError(f"expected the arrays of a rig, found {shown(min(unknown), 60)!r}")
        for key in _REQUIRED:
            if key not in arrays:
                raise InputError(f"expected a rig with {key}, found none")
        return _rig({key: _value(key, array) for key, array in arrays.items()})


def write_rig(path: str | Path, rig: Rig) -> None:
    """Write a rig; what is None is absent; the same rig gives the same bytes.

    Raises OutputError when the file cannot be written.
    """
    values: dict = {"names": rig.names, "neutral": rig.neutral, "deltas": rig.deltas} | mesh_to_arrays(rig.mesh)
    values |= {key: getattr(rig, key) for key in _LOOKS}
    values |= dict(zip(_TEXTURES, rig.pictures, strict=True)) | _depiction_arrays(rig.depiction)
    if rig.moods:
        values["moods"] = [mood.name for mood in rig.moods]
        values["mood_textures"] = np.stack([mood.skin for mood in rig.moods])
    if rig.changes is not None:
        values |= {"changes": rig.changes.picture, "change_layout": rig.changes.layout}
    arrays = {key: np.array(text) for key, text in _TEXTS.items()}
    for key, stored in _STORED.items():
        if values.get(key) is not None:
            arrays[key] = np.asarray(values[key], stored)
    write_npz(path, arrays)


def _value(key: str, array: np.ndarray) -> np.ndarray:
    stored = np.dtype(_STORED[key])
    # A whole number that does not fit would come out as another one.
    if array.dtype.kind != stored.kind or (stored.kind in "iu" and (array.astype(stored) != array).any()):
        raise InputError(f"{key}: expected {stored.name}, found {array.dtype}")
    if stored.kind == "U":
        return array
    # What single precision cannot hold becomes infinite, which the structures refuse.
    with np.errstate(over="ignore"):
        return array.astype(stored)


def _rig(values: dict) -> Rig:
    names = values["names"]
    if names.ndim != 1:
        raise InputError(f"names: expected a list of names, found {names.shape}")
    mesh = mesh_from_arrays(values, "neutral")
    pictures = Pictures(**{name: values.get(key) for key, name in _TEXTURES.items()})
    looks: dict = {key: values.get(key) for key in _LOOKS}
    moods = _moods(values.get("moods", np.zeros(0, np.str_)), values.get("mood_textures", np.zeros(0, np.uint8)))
    looks |= {"moods": moods, "depiction": _depiction(values), "changes": _changes(values)}
    return Rig(tuple(names.tolist()), mesh, values["deltas"], pictures=pictures, **looks)


def _moods(names: np.ndarray, textures: np.ndarray) -> tuple[Mood, ...]:
    if names.ndim != 1 or textures.shape[:1] != names.shape:
        raise InputError(f"moods: expected a name for every picture, found {names.shape} and {textures.shape}")
    return tuple(Mood(name, texture) for name, texture in zip(names.tolist(), textures, strict=True))


def _changes(values: dict) -> ChangeAtlas | None:
    if "changes" not in values and "change_layout" not in values:
        return None
    if "changes" not in values or "change_layout" not in values:
        raise InputError("changes: expected them together with change_layout, found only one")
    return ChangeAtlas.laid_out(values["changes"], values["change_layout"])


def _depiction_arrays(depiction: Depiction | None) -> dict[str, np.ndarray | float | None]:
    if depiction is None:
        return {}
    camera = depiction.camera
    values: dict = dict(zip(_CAMERA, [camera.scale, camera.rotation, camera.translation], strict=True))
    return values | {"depicted": depiction.vertices, "landmarks": depiction.landmarks}


def _depiction(values: dict) -> Depiction | None:
    """The Depiction of values by key, or None. Raises InputError for half of one."""
    expected = (*_CAMERA, "depicted")
    given = [key for key in (*expected, "landmarks") if key in values]
    if not given:
        return None
    if any(key not in values for key in expected):
        raise InputError(f"camera: expected {', '.join(expected)}, found only {', '.join(given)}")
    camera = Camera(*(values[key] for key in _CAMERA))
    return Depiction(camera, values["depicted"], values.get("landmarks"))
