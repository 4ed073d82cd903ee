"""Any file of ours, or anybody's mesh, by what is in it."""

import os
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data import picture_set, sketch_set, texture_set
from caricli.data.dataset import MANIFEST as DATASET_MANIFEST
from caricli.data.dataset import SCHEMA as DATASET_SCHEMA
from caricli.data.dataset import read_dataset
from caricli.data.expressions import NEUTRAL, read_expressions
from caricli.errors import InputError, shown
from caricli.io import directions, face, landmarks, parsing, rig, session
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.files import content_kind, is_usd, read_start, text_start, without_utf16
from caricli.io.gltf.format import SUFFIXES
from caricli.io.gltf.read_clips import read_clips
from caricli.io.gltf.read_gltf import read_gltf, read_gltf_mesh
from caricli.io.image import is_image_file, read_image
from caricli.io.meshes.mesh import ANY_MESH, is_mesh_file, read_mesh
from caricli.io.meshes.mtl import material_pictures
from caricli.io.meshes.obj import read_obj
from caricli.io.meshes.ply import read_ply
from caricli.io.meshes.stl import read_stl
from caricli.io.npz import read_npz, text_of
from caricli.io.sketches import sketch
from caricli.io.sketches.svg import is_svg
from caricli.io.strict_json import read_json
from caricli.io.takes import cues, track
from caricli.methods.inspect.inspection import Acquaintances, Animated, FolderPart
from caricli.models.checkpoint import model_from_checkpoint
from caricli.models.coarse.model import SCHEMA as COARSE_SCHEMA
from caricli.models.coarse.model import coarse_from_checkpoint
from caricli.models.detector.model import SCHEMA as DETECTOR_SCHEMA
from caricli.models.detector.model import detector_from_checkpoint
from caricli.models.gesture.model import SCHEMA as GESTURE_SCHEMA
from caricli.models.gesture.model import gesture_from_checkpoint
from caricli.models.kinds import KINDS
from caricli.models.landmark_map.model import SCHEMA as LANDMARK_MAP_SCHEMA
from caricli.models.landmark_map.model import map_from_checkpoint
from caricli.models.sketch.model import SCHEMA as SKETCH_NETWORK_SCHEMA
from caricli.models.sketch.model import sketch_from_checkpoint
from caricli.models.strokes.model import SCHEMA as STROKES_SCHEMA
from caricli.models.strokes.model import strokes_from_checkpoint
from caricli.models.style.model import SCHEMA as STYLE_SCHEMA
from caricli.models.style.model import style_from_checkpoint
from caricli.models.texture.model import SCHEMA as TEXTURE_SCHEMA
from caricli.models.texture.model import texture_from_checkpoint
from caricli.store.models import load_model
from caricli.structures.arkit import ARKIT_NAMES

_EXPECTED = f"a file of caricli's, or {ANY_MESH}"

_START = 4096
"""Bytes that tell what is in a file."""

_OBJ = re.compile(rb"^[^\S\n]*(?:v|vt|vn|f|o|g|mtllib|usemtl)\s", re.MULTILINE)
_CSV = re.compile(rb"^[^\n]*timecode", re.IGNORECASE)

_NPZ = {face.SCHEMA: face.read_face, rig.SCHEMA: rig.read_rig, directions.SCHEMA: directions.read_directions}
_JSON: dict[str, Callable[[Path], Any]] = {
    landmarks.SCHEMA: landmarks.read_landmarks,
    track.SCHEMA: track.read_weights,
    sketch.SCHEMA: sketch.read_sketch,
    session.SCHEMA: session.read_session,
    parsing.SCHEMA: parsing.read_legend,
    DATASET_SCHEMA: lambda path: read_dataset(path.parent),
    picture_set.SCHEMA: lambda path: picture_set.read_picture_set(path.parent),
    sketch_set.SCHEMA: lambda path: sketch_set.read_sketch_set(path.parent),
    texture_set.SCHEMA: lambda path: texture_set.read_texture_set(path.parent),
}
_FOLDERS: dict[str, Callable[[Path], Any]] = {
    DATASET_MANIFEST: read_dataset,
    picture_set.MANIFEST: picture_set.read_picture_set,
    sketch_set.MANIFEST: sketch_set.read_sketch_set,
    texture_set.MANIFEST: texture_set.read_texture_set,
}
_PARTS = (
    ("a dataset", "identity", "meshes", {"vertices", "identity", "expression", "level"}),
    ("a dataset", "attributes", "labels", {"attributes", "measures", "labels"}),
    ("a dataset", "vertices", "vertices", {"vertices", "faces", "polygons"}),
    ("a dataset", "albedo", "albedos", {"albedo"}),
    ("pictures", "picture", "faces", set(picture_set.COLUMNS)),
    ("sketches", "strokes", "sketches", {"strokes", "lengths", "points", *sketch_set.TRUTH}),
    ("textures", "person", "people", set(texture_set.COLUMNS)),
)
"""Files of folders, which have no schema: the folder, the array that counts, what it counts, arrays that are there."""

_WEIGHTS: dict[Any, Callable[..., Any]] = {
    LANDMARK_MAP_SCHEMA: map_from_checkpoint,
    DETECTOR_SCHEMA: detector_from_checkpoint,
    COARSE_SCHEMA: coarse_from_checkpoint,
    SKETCH_NETWORK_SCHEMA: sketch_from_checkpoint,
    STROKES_SCHEMA: strokes_from_checkpoint,
    STYLE_SCHEMA: style_from_checkpoint,
    GESTURE_SCHEMA: gesture_from_checkpoint,
    TEXTURE_SCHEMA: texture_from_checkpoint,
}


def load_any(path: Path) -> Any:
    """What a file or folder holds, told by its content: one of the structures, a Dataset, a PictureSet, a SketchSet, a
    TextureSet, a FolderPart, a ShapeModel, a LandmarkMap, a Detector, a CoarseModel, a SketchModel, a StrokeModel, a
    StyleModel, a GestureModel, a TextureModel, the dict of a report, a legend or expressions, or the array of a
    picture.

    Raises InputError when it is none of them, or damaged.
    """
    if path.is_dir():
        return _folder_reader(path)(path)
    return _reader(without_utf16(read_start(path, _START, _EXPECTED)), path)(path)


def load_acquaintances() -> Acquaintances:
    """What files can refer to: the head and the bundled models."""
    reports = {kind: asset_path(f"{kind}.json") for kind in KINDS}
    models = {read_json(report)["model_id"]: kind for kind, report in reports.items() if report.is_file()}
    return Acquaintances(load_model(kind="pca").template, models)


def files_beside(path: Path) -> list[str]:
    """Names of the files of the same stem, and of the picture that an OBJ names."""
    if path.is_dir():
        return []
    names = {other.name for other in path.parent.iterdir() if other.stem == path.stem and other.name != path.name}
    if path.suffix.lower() == ".obj":
        # What is told of a file does not end where its materials cannot be read.
        with suppress(InputError):
            pictures = [picture for picture in material_pictures(path).values() if os.path.isfile(picture)]
            names |= {picture.relative_to(path.parent).as_posix() for picture in pictures}
    return sorted(names)


def _folder_reader(folder: Path) -> Callable[[Path], Any]:
    """The function that reads a folder. Raises InputError for one without a manifest."""
    for name, read in _FOLDERS.items():
        if (folder / name).exists():
            return read
    raise InputError(
        f"{shown(folder)}: expected a folder of a dataset, of pictures, sketches or textures, found none of "
        f"{', '.join(_FOLDERS)} in it: it is another, of which a single file can be given, or its making was stopped"
    )


def _reader(start: bytes, path: Path) -> Callable[[Path], Any]:
    """The function that reads a file that begins so."""
    suffix = path.suffix.lower()
    if is_usd(start):
        raise InputError(f"{shown(path)}: expected a file that caricli reads, found {content_kind(start)}")
    if cues.is_cues(start):
        return cues.read_cues
    if is_svg(start):
        return sketch.read_sketch
    signatures: dict[bytes, Callable[[Path], Any]] = {
        b"PK": _read_arrays,
        b"glTF": _read_gltf,
        b"\x93NUMPY": landmarks.read_landmarks,
        b"ply": read_ply,
        b"solid ": read_stl,
    }
    for signature, reader in signatures.items():
        if start.startswith(signature):
            return reader
    if start[8:9] == b"{" and start[4:8] == bytes(4):
        return _read_weights_of_model
    if suffix == ".npz":
        return read_npz
    return _text_reader(start, path)


def _text_reader(start: bytes, path: Path) -> Callable[[Path], Any]:
    suffix = path.suffix.lower()
    rubbish = content_kind(start)
    if rubbish and is_image_file(path):
        return read_image
    if suffix in SUFFIXES:
        return _read_gltf
    if is_mesh_file(path):
        return read_mesh
    if rubbish:
        raise InputError(f"{shown(path)}: expected {_EXPECTED}, found {rubbish}")
    if text_start(start)[:1] in (b"{", b"["):
        return _read_json
    if suffix in (".yaml", ".yml"):
        return _read_expressions
    if _CSV.match(start):
        return track.read_weights
    if _OBJ.search(start):
        return read_obj
    if suffix in (".pts", ".txt") or start.startswith(b"version"):
        return landmarks.read_landmarks
    raise InputError(f"{shown(path)}: expected {_EXPECTED}, found other text")


def _read_arrays(path: Path) -> Any:
    arrays = read_npz(path)
    schema = text_of(arrays.get("schema"))
    if schema in _NPZ:
        return _NPZ[schema](path)
    if {"names", "weights"} <= set(arrays):
        return track.read_weights(path)
    for folder, key, counted, names in _PARTS:
        if names <= set(arrays):
            return FolderPart(folder, len(np.atleast_1d(arrays[key])), counted, tuple(arrays))
    listed = shown(", ".join(arrays), 60)
    raise InputError(f"{shown(path)}: expected a face, a rig, directions or weights, found an NPZ with {listed}")


def _read_gltf(path: Path) -> Any:
    """A Rig where there are shapes or materials of a head, else the Mesh of the scene; Animated where it moves."""
    content = read_gltf(path)
    still = content if content.names or content.materials is not None else read_gltf_mesh(path)
    clips = read_clips(path)
    return Animated(still, clips) if clips else still


def _read_weights_of_model(path: Path) -> Any:
    tensors, metadata = read_checkpoint(path)
    schema = metadata.get("schema")
    rebuild = _WEIGHTS.get(schema, model_from_checkpoint) if isinstance(schema, str) else model_from_checkpoint
    return rebuild(tensors, metadata, shown(path))


def _read_json(path: Path) -> Any:
    value = read_json(path)
    schema = value.get("schema") if isinstance(value, dict) else None
    if isinstance(schema, str) and schema in _JSON:
        return _JSON[schema](path)
    if schema is not None:
        raise InputError(f"{shown(path)}: expected {_EXPECTED}, found JSON of schema {shown(schema, 60)!r}")
    if isinstance(value, dict) and "asset" in value:
        return _read_gltf(path)
    if isinstance(value, dict) and isinstance(value.get("command"), str):
        return value
    if isinstance(value, dict) and NEUTRAL in value:
        return _read_expressions(path)
    return track.read_weights(path)


def _read_expressions(path: Path) -> dict[str, dict[str, float]]:
    return read_expressions(path, ARKIT_NAMES)
