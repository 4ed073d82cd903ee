"""Every reader of caricli, with good files to start from and a way to change what is inside them."""

import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from trimesh import Trimesh
from trimesh.exchange.ply import export_ply
from trimesh.exchange.stl import export_stl_ascii

from caricli.data.dataset import MANIFEST, SCHEMA, read_dataset
from caricli.data.expressions import read_expressions
from caricli.data.import_dataset import read_labels
from caricli.data.mesh_names import read_mesh_name
from caricli.data.picture_set import read_picture_set
from caricli.data.sketch_set import SketchWriter, read_sketch_set
from caricli.data.summarise_pictures import summarise_pictures
from caricli.data.summarise_textures import summarise_textures
from caricli.data.texture_set import ActedTextures, TextureWriter, read_texture_set
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.config import read_config
from caricli.io.directions import read_directions, write_directions
from caricli.io.face import read_face, read_picture_names, write_face
from caricli.io.gltf.read_clips import read_clips
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_alpha, read_image
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.meshes.mesh import MESH_SUFFIXES, read_mesh, write_mesh
from caricli.io.meshes.mtl import material_pictures
from caricli.io.npz import read_npz, write_npz
from caricli.io.parsing import read_legend, read_parsing
from caricli.io.provenance import sha256_file
from caricli.io.rig import read_rig, write_rig
from caricli.io.session import read_session, write_session
from caricli.io.sketches.sketch import read_sketch, write_sketch
from caricli.io.sketches.svg import read_svg
from caricli.io.strict_json import parse_json, read_json, write_json
from caricli.io.takes.cues import read_cues
from caricli.io.takes.track import read_weights
from caricli.io.training_state import read_state, write_state
from caricli.methods.edit.handle_points import handle_points
from caricli.models.checkpoint import model_to_checkpoint
from caricli.models.coarse.config import CoarseSize
from caricli.models.coarse.model import CoarseModel, coarse_to_checkpoint
from caricli.models.coarse.networks import CoarseNetwork
from caricli.models.deformable.config import DeformableConfig, NetworkSize
from caricli.models.deformable.model import DeformableModel
from caricli.models.deformable.networks import HyperSiren
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.model import detector_to_checkpoint
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.models.gesture.model import GestureModel, gesture_to_checkpoint
from caricli.models.gesture.networks import GestureNetwork
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.kernel.gaussian_process import GaussianProcess
from caricli.models.kernel.model import KernelModel
from caricli.models.landmark_map.model import DOMAINS, LandmarkMap, map_to_checkpoint
from caricli.models.linear_basis import LinearBasis
from caricli.models.morphable.model import MorphableModel, ShapeBases
from caricli.models.pca.model import PcaModel
from caricli.models.prior import Prior
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import SketchModel, sketch_to_checkpoint
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.models.strokes.config import StrokeSize
from caricli.models.strokes.model import StrokeModel, strokes_to_checkpoint
from caricli.models.strokes.networks import StrokeNetwork
from caricli.models.style.model import StyleModel, style_to_checkpoint
from caricli.models.style.networks import StyleNetwork
from caricli.models.texture.config import TextureSize
from caricli.models.texture.model import TextureModel, texture_to_checkpoint
from caricli.models.texture.networks import TextureNetwork
from caricli.store.any_file import load_any
from caricli.store.coarse import load_coarse
from caricli.store.detector import load_detector
from caricli.store.faces import load_latent_face
from caricli.store.gestures import load_gestures
from caricli.store.handles import load_handles
from caricli.store.landmark_maps import load_landmark_map
from caricli.store.models import load_model
from caricli.store.sketch_networks import load_sketch_network
from caricli.store.strokes import load_strokes
from caricli.store.styles import load_style
from caricli.store.texture_networks import load_texture_network
from caricli.structures import (
    Animation,
    Camera,
    Directions,
    Face,
    Hair,
    Landmarks,
    Material,
    Mesh,
    Mood,
    Operation,
    Part,
    Pictures,
    Rig,
    Session,
    Sketch,
    Start,
    Stroke,
    StrokeKind,
    Track,
)
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.gesture import GESTURES
from caricli.structures.parsing import Region
from caricli.template.annotation import parse_annotation
from caricli.template.own_parts import read_own_parts
from caricli.template.template import FittedParts, Template
from tests.fuzz.mutate import Mutation, mutate_arrays, mutate_glb, mutate_json, mutate_members, mutate_tensors
from tests.written_weights import write_weights

_RANDOM = np.random.default_rng(0)


@dataclass(frozen=True)
class Reader:
    """How a reader is tried.

    name: of the file that it is given. read: takes its path. seeds: write good files to a path. mutate: changes what
    is inside one, or None for bytes alone.
    """

    name: str
    read: Callable[[Path], object]
    seeds: tuple[Callable[[Path], object], ...]
    mutate: Mutation | None = None

    def good_files(self, folder: Path) -> list[bytes]:
        """The contents of the good files."""
        contents = []
        for write in self.seeds:
            write(folder / self.name)
            contents.append((folder / self.name).read_bytes())
        return contents


def _grid(rows: int, columns: int) -> Mesh:
    """A bent sheet of quads with UVs."""
    v, u = (a.ravel() / (n - 1) for a, n in zip(np.mgrid[:rows, :columns], (rows, columns), strict=True))
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = np.stack([first, first + 1, first + columns + 1, first + columns], axis=1).astype(np.int32)
    points = np.stack([0.2 * u, 0.24 * v, 0.1 * np.sin(3 * u) * np.cos(2 * v)], axis=1)
    return Mesh(points, quads, np.stack([u, v], axis=1), quads)


MESH = _grid(4, 3)
HEAD = _grid(12, 10)
MARKS = Landmarks(
    np.stack([20 * np.arange(68.0) % 97, np.arange(68.0)], axis=1),
    (100, 100),
    np.tile(np.eye(2), (68, 1, 1)),
    np.ones(68),
)
PICTURE = _RANDOM.integers(0, 256, (8, 8, 3), np.uint8)
CAMERA = Camera(300.0, np.diag([1.0, -1.0, -1.0]), np.array([40.0, 60.0]))
PARTS = {"teeth_lower": {"file": "teeth.obj", "hangs_on": "jaw"}}
ANNOTATION = {"ibug68": list(range(68)), "regions": {"face": [1, 2, 3], "jaw": [4, 5, 6, 7]}, "eyeballs": {}}
SESSION = Session(
    Start("face.npz", "0f" * 32),
    (
        Operation("draw", {"points": [[1, 2.5], [3, 4]], "width": 2.0}),
        Operation("expression", {"weights": {"jawOpen": 0.5}}),
    ),
)
WEIGHTS = [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]


@cache
def template() -> Template:
    """A template of 120 vertices."""
    annotation = parse_annotation(ANNOTATION, len(HEAD.vertices), "annotation")
    return Template(HEAD.vertices, HEAD.polygons, HEAD.uvs, HEAD.uv_polygons, annotation=annotation)


def _models() -> list[ShapeModel]:
    own = template()
    count = len(own.vertices)
    bases = _RANDOM.normal(0, 0.004, (3, 4, count, 3))
    process = GaussianProcess(np.full(3, 0.2), _RANDOM.normal(size=(5, 3)), _RANDOM.normal(size=(5, 1)))
    network = HyperSiren(NetworkSize(2, 4, 2, 4), torch.Generator().manual_seed(0))
    features = _RANDOM.normal(0, 0.05, (4, count, 9))
    shapes = ShapeBases(own.vertices, bases[0], bases[1][:2], 0.003)
    teeth = Part(
        "teeth_lower", MESH, np.zeros(len(MESH.polygons), np.int32), "jaw", (), np.zeros((0, len(MESH.vertices), 3))
    )
    note = parse_annotation(ANNOTATION | {"parts": PARTS}, count, "annotation")
    whole = replace(own, annotation=note, parts=FittedParts(own, (teeth,)))
    return [
        PcaModel(own, own.vertices, bases[0]),
        PcaModel(whole, own.vertices, bases[0]),
        IntrinsicModel(own, features[0], features[:3], np.zeros((4, 3))),
        KernelModel(own, own.vertices, bases[1], process),
        MorphableModel(own, shapes, LinearBasis(np.full((count, 3), 0.6), 0.1 * bases[2])),
        DeformableModel(own, network, own.vertices, Prior.standard(2)),
    ]


def _use_model(path: Path) -> None:
    """Read a model and make a face and a latent of it."""
    model = load_model(path)
    shape = model.decode(model.prior.sample(np.random.default_rng(0), 1)[0])
    model.encode(model.template.with_vertices(shape).vertices)


def _write_map(path: Path) -> None:
    normal, caricature = _RANDOM.normal(size=(2, 136))
    landmark_map = LandmarkMap(normal, caricature, _RANDOM.normal(size=(136, 136)), _RANDOM.normal(size=(3, 136)))
    write_checkpoint(path, *map_to_checkpoint(landmark_map, {}))


def _map_marks(path: Path) -> None:
    landmark_map = load_landmark_map(path)
    for name in DOMAINS:
        landmark_map.map(MARKS.points, name)


def _rig() -> Rig:
    deltas = _RANDOM.normal(0, 0.01, (2, len(MESH.vertices), 3)).astype(np.float32)
    skin = Mesh(MESH.vertices.astype(np.float32), MESH.polygons, MESH.uvs, MESH.uv_polygons)
    materials = np.array([Material.EYE, *[Material.SKIN] * (len(MESH.polygons) - 1)], np.int32)
    moods = (Mood("sad", PICTURE), Mood("b", PICTURE))
    return Rig(("jawOpen", "b"), skin, deltas, materials, Pictures(PICTURE, PICTURE, PICTURE), deltas[:, :5], moods)


def _directions() -> Directions:
    return Directions(
        names=("BigNose", "Smile"), normals=np.eye(2, 4), gradients=np.eye(2, 4), auc=np.array([0.9, 0.8]),
        positives=np.array([3, 4]), count=9, cost=np.ones(2), change=np.ones(2), model_id="m", recipe={"a": 1},
        people=_RANDOM.normal(size=(3, 4)),
    )  # fmt: skip


def _face() -> Face:
    own = template()
    residual = _RANDOM.normal(0, 0.01, (len(own.vertices), 9))
    return Face(HEAD, CAMERA, MARKS.points, _RANDOM.normal(size=4), residual, _pca().model_id)


def _worn(path: Path) -> None:
    """A face that wears pictures."""
    roots = np.array([[0, 1, 2]] * len(MESH.vertices), np.int32)
    hair = Hair(MESH, roots, np.full(roots.shape, 1 / 3))
    polygons = len(HEAD.polygons)
    wearing = replace(_face(), pictures=Pictures(PICTURE, PICTURE, PICTURE), hair=hair)
    write_face(path, replace(wearing, materials=np.zeros(polygons, np.int32)))


def _read_name(path: Path) -> None:
    read_mesh_name(path.read_bytes().decode("utf-8", "replace"))


@cache
def _pca() -> ShapeModel:
    own = template()
    return PcaModel(own, own.vertices, _RANDOM.normal(0, 0.004, (4, len(own.vertices), 3)))


def _load_face(path: Path) -> None:
    load_latent_face(path, _pca())


def _sketch() -> Sketch:
    bent = Stroke(np.array([[1.0, 2], [3, 4.5], [1, 2]]), StrokeKind.FEATURE, "nose", np.array([0, 0.5, 1]), 2.0)
    return Sketch((bent, Stroke(np.array([[9.0, 9]]))), (64, 48))


SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 30"><style>.a{stroke:red}</style>'
    '<g id="feature" transform="rotate(5) scale(.5)"><path id="nose" class="a" d="M1 2C3 4 5 6 7 8s1 1 2 2q1 2 3 4t1 1'
    'a3 4 5 0 1 6 7h2v3z"/><circle id="c" r="3" stroke="red"/></g><use href="#c" x="3"/>'
    '<polyline stroke="black" data-pressure="0 1" points="1,2 3,4"/><rect width="3" height="4"/></svg>'
)


def _live_link(path: Path) -> None:
    names = [name[0].upper() + name[1:] for name in ARKIT_NAMES]
    header = ["Timecode", "BlendShapeCount", *names, "HeadYaw", "HeadPitch", "HeadRoll"]
    rows = [f"10:00:{k:02d}:{k * 11:02d}.500,55," + ",".join(["0.25"] * 55) for k in range(3)]
    path.write_text("\n".join([",".join(header), *rows]) + "\n")


def _mediapipe(path: Path) -> None:
    categories = [{"categoryName": name, "score": 0.5} for name in ("_neutral", "jawOpen", "mouthClose")]
    matrix = np.eye(4).tolist()
    result = {"faceBlendshapes": [{"categories": categories}], "facial_transformation_matrixes": [matrix]}
    path.write_text(json.dumps({"frames": [result | {"timestampMs": 40 * k} for k in range(3)]}))


CUES = [{"start": 0.0, "end": 0.3, "value": "A"}, {"start": 0.3, "end": 0.5, "value": "D"}]
XML = (
    "<rhubarbResult><metadata><duration>0.9</duration></metadata><mouthCues>"
    '<mouthCue start="0.00" end="0.30">X</mouthCue></mouthCues></rhubarbResult>'
)
TREE = {"asset": {"version": "2.0"}, "a": [1, 2.5, None, True, "x"]}


def _text(text: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(text, "utf-8")


def _json(value: Any) -> Callable[[Path], object]:
    return _text(json.dumps(value))


def _picture(kind: str, mode: str = "RGB", **options: Any) -> Callable[[Path], object]:
    return lambda path: Image.fromarray(PICTURE).convert(mode).save(path, kind, **options)


def _write_detector(path: Path) -> None:
    network = DetectorNetwork(DetectorSize(4, 8, 1), 81, len(Region), torch.Generator().manual_seed(0))
    write_checkpoint(path, *detector_to_checkpoint(detector_of(network, 64)))


def _write_sketch_network(path: Path) -> None:
    size = SketchSize(4, (4, 4, 4), (0, 0, 0), 4, 4, 4)
    network = SketchNetwork(size, 2, POINTS, 3, torch.Generator().manual_seed(0))
    write_checkpoint(path, *sketch_to_checkpoint(SketchModel(network, 64, ("nose", "silhouette"), "none")))


def _write_stroke_network(path: Path) -> None:
    network = StrokeNetwork(StrokeSize((4, 4, 4, 4), (0, 0, 0, 0), 3, 4), 3, torch.Generator().manual_seed(0))
    write_checkpoint(path, *strokes_to_checkpoint(StrokeModel(network, 64, ("nose", "silhouette"))))


def _write_texture_network(path: Path) -> None:
    network = TextureNetwork(TextureSize(4, 4), torch.Generator().manual_seed(0))
    write_checkpoint(path, *texture_to_checkpoint(TextureModel(network, 32, "0" * 64)))


def _write_gestures(path: Path) -> None:
    network = GestureNetwork(16, 1, len(GESTURES), torch.Generator().manual_seed(0))
    write_checkpoint(path, *gesture_to_checkpoint(GestureModel(network)))


def _write_style(path: Path) -> None:
    network = StyleNetwork(4, 2, torch.Generator().manual_seed(0))
    write_checkpoint(path, *style_to_checkpoint(StyleModel(network, ("oil", "pencil"))))


def _write_coarse(path: Path) -> None:
    size = CoarseSize(4, (8, 8, 8, 8), (0, 0, 0, 0), False, 2, 4)
    network = CoarseNetwork(size, 81, 20, torch.Generator().manual_seed(0))
    write_checkpoint(path, *coarse_to_checkpoint(CoarseModel(network, 64, "none")))


def _picture_of_eyes(path: Path) -> None:
    write_json(path.with_suffix(".json"), {"schema": "caricli.parsing/1", "labels": {"skin": 1}})
    _picture("PNG", "L")(path)


def _read_material(path: Path) -> None:
    path.with_name("a.obj").write_bytes(path.read_bytes())
    path.with_name("a.mtl").write_bytes(path.read_bytes())
    material_pictures(path.with_name("a.obj"))


def _read_annotation(path: Path) -> None:
    note = parse_annotation(read_json(path), 120, path.name)
    own = Template(HEAD.vertices, HEAD.polygons, annotation=note)
    _ = own.gradients, own.cavities
    write_mesh(path.with_name("teeth.obj"), MESH)
    read_own_parts(own, path, own.vertices, 1.0)


def _state(path: Path) -> None:
    state = {"network": {"w": torch.arange(3.0)}, "counters": [1, 2.5, 0], "log": [{"epoch": 1}]}
    write_state(path, state, {"config": {"seed": 0}, "inputs": {"a": "b"}})


def _dataset_bundle(path: Path) -> None:
    """All arrays of a dataset in one NPZ, "file/array", and its manifest as text."""
    own = template()
    parts = {
        "template": {"vertices": own.vertices, "faces": own.faces, "polygons": own.polygons},
        "shard-0000": _shard(2),
        "shard-0001": _shard(3),
        "labels": {"attributes": np.array(["a", "b"]), "measures": np.zeros((5, 2)), "labels": np.ones((5, 2), bool)},
    }
    manifest = {
        "schema": SCHEMA,
        "topology_id": own.topology_id,
        "splits": {"train": [0, 1], "validation": [2], "test": [3]},
        "annotation": ANNOTATION,
        "template": {"file": "template.npz"},
        "labels": {"file": "labels.npz"},
        "shards": [{"file": "shard-0000.npz", "count": 2}, {"file": "shard-0001.npz", "count": 3}],
    }
    arrays = {f"{file}|{key}": value for file, entries in parts.items() for key, value in entries.items()}
    write_npz(path, arrays | {"manifest": np.array(json.dumps(manifest))})


def _shard(count: int) -> dict[str, np.ndarray]:
    numbers = np.arange(count, dtype=np.int32)
    shapes = np.repeat(HEAD.vertices[None], count, axis=0).astype(np.float32)
    return {
        "vertices": shapes,
        "identity": numbers,
        "expression": 0 * numbers,
        "level": 0 * numbers,
        "age": 0.1 * numbers,
    }


def _read_bundle(path: Path) -> None:
    """Make the folder that a bundle stands for, its hashes right, and read it."""
    arrays = read_npz(path)
    folder = path.with_name("dataset")
    folder.mkdir(exist_ok=True)
    manifest = parse_json(str(arrays.pop("manifest", "{}")).encode(), "manifest")
    files: dict[str, dict[str, np.ndarray]] = {}
    for name, array in arrays.items():
        file, _, key = name.partition("|")
        files.setdefault(f"{file}.npz", {})[key] = array
    hashes = {}
    for file, entries in files.items():
        if file.isalnum() or file in ("template.npz", "labels.npz", "shard-0000.npz", "shard-0001.npz"):
            write_npz(folder / file, entries)
            hashes[file] = sha256_file(folder / file)
    for entry in _entries(manifest):
        if isinstance(entry.get("file"), str) and entry["file"] in hashes:
            entry["sha256"] = hashes[entry["file"]]
    write_json(folder / MANIFEST, manifest)
    read_dataset(folder)


def _pictures_bundle(path: Path) -> None:
    """The truth of a folder of pictures, and its manifest as text."""
    faces = 3
    arrays = {
        "picture": np.array([0, 0, 2], np.int32),
        "landmarks": np.zeros((faces, 4, 2), np.float32),
        "visible": np.ones((faces, 4), bool),
        **{name: np.arange(faces, dtype=np.int32) for name in ("person", "expression", "level")},
        **{name: np.ones(faces, np.float32) for name in ("scale", "perspective")},
        "rotation": np.ones((faces, 3, 3), np.float32),
        "translation": np.ones((faces, 2), np.float32),
        "light": np.ones((faces, 9, 3), np.float32),
        "coefficients": np.ones((faces, 5), np.float32),
    }
    splits = {"train": [0, 1], "validation": [2], "test": [3]}
    truth = {"file": "truth.npz"}
    manifest = {"schema": "caricli.pictures/1", "count": 3, "media": ["flat"] * 3, "splits": splits, "truth": truth}
    write_npz(path, arrays | {"manifest": np.array(json.dumps(manifest))})


def _read_pictures(path: Path) -> None:
    """Make the folder that a bundle stands for, its hash right, and read and describe it."""
    arrays = read_npz(path)
    folder = path.with_name("pictures")
    folder.mkdir(exist_ok=True)
    manifest = parse_json(str(arrays.pop("manifest", "{}")).encode(), "manifest")
    write_npz(folder / "truth.npz", arrays)
    if isinstance(manifest, dict) and isinstance(manifest.get("truth"), dict):
        manifest["truth"]["sha256"] = sha256_file(folder / "truth.npz")
    write_json(folder / "pictures.json", manifest)
    summarise_pictures(read_picture_set(folder))


def _sketches_bundle(path: Path) -> None:
    """A shard of a folder of sketches, and its manifest as text."""
    folder = path.with_name("drawn")
    if not folder.exists():
        writer = SketchWriter(folder, ("nose",))
        truth: dict[str, Any] = {"row": 1, "person": 0, "expression": 2, "level": 1, "scale": 2.0}
        truth |= {"rotation": np.eye(3), "translation": np.ones(2)}
        writer.add(_sketch(), b"a picture", truth)
        writer.finish({"side": 64, "splits": {"train": [0, 1], "validation": [2], "test": [3]}})
    manifest = (folder / "sketches.json").read_text()
    write_npz(path, read_npz(folder / "strokes-0000.npz") | {"manifest": np.array(manifest)})


def _read_sketches(path: Path) -> None:
    """Make the folder that a bundle stands for, its hash right, and read its strokes."""
    arrays = read_npz(path)
    folder = path.with_name("sketches")
    folder.mkdir(exist_ok=True)
    manifest = parse_json(str(arrays.pop("manifest", "{}")).encode(), "manifest")
    write_npz(folder / "strokes-0000.npz", arrays)
    shards = manifest.get("shards") if isinstance(manifest, dict) else None
    for entry in shards if isinstance(shards, list) else []:
        if isinstance(entry, dict):
            entry["sha256"] = sha256_file(folder / "strokes-0000.npz")
    write_json(folder / "sketches.json", manifest)
    read_sketch_set(folder).sketches(0)


def _textures_bundle(path: Path) -> None:
    """A shard of a folder of textures, and its manifest as text."""
    folder = path.with_name("acted")
    if not folder.exists():
        folder.mkdir()
        writer = TextureWriter(folder)
        shapes = np.zeros((2, 4, 3), np.float32)
        pictures = np.zeros((2, 3, 3, 3), np.uint8)
        weights = np.zeros((2, len(ARKIT_NAMES)), np.float32)
        writer.add(ActedTextures(pictures, pictures[..., 0] > 0, weights, shapes, shapes[0], 1, 2, "train", 0.5))
        splits = {"train": [0, 1], "validation": [2], "test": [3]}
        writer.finish({"size": 3, "expressions": 2, "splits": splits})
    manifest = (folder / "textures.json").read_text()
    write_npz(path, read_npz(folder / "shard-0000.npz") | {"manifest": np.array(manifest)})


def _read_textures(path: Path) -> None:
    """Make the folder that a bundle stands for, its hash right, and read and describe it."""
    arrays = read_npz(path)
    folder = path.with_name("textures")
    folder.mkdir(exist_ok=True)
    manifest = parse_json(str(arrays.pop("manifest", "{}")).encode(), "manifest")
    write_npz(folder / "shard-0000.npz", arrays)
    shards = manifest.get("shards") if isinstance(manifest, dict) else None
    for entry in shards if isinstance(shards, list) else []:
        if isinstance(entry, dict):
            entry["sha256"] = sha256_file(folder / "shard-0000.npz")
    write_json(folder / "textures.json", manifest)
    summarise_textures(read_texture_set(folder))


def _entries(manifest: Any) -> list[dict]:
    values = list(manifest.values()) if isinstance(manifest, dict) else []
    shards = [value for value in values if isinstance(value, list)]
    return [entry for entry in (*values, *(part for shard in shards for part in shard)) if isinstance(entry, dict)]


def _mutate_bundle(data: bytes, rng: Any) -> bytes:
    """Change an array or the manifest."""
    if rng.random() < 0.5:
        return mutate_arrays(data, rng)
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(stream, "w") as copy:
        for name in archive.namelist():
            content = archive.read(name)
            if name == "manifest.npy":
                text = str(np.load(io.BytesIO(content)))
                array = io.BytesIO()
                np.save(array, np.array(mutate_json(text.encode(), rng).decode()))
                content = array.getvalue()
            copy.writestr(name, content)
    return stream.getvalue()


def _model_seeds() -> tuple[Callable[[Path], object], ...]:
    return tuple(
        lambda path, model=model: write_checkpoint(path, *model_to_checkpoint(model, {})) for model in _models()
    )


def _mesh_reader(suffix: str) -> Reader:
    def write(path: Path) -> None:
        write_mesh(path, MESH)

    flat = Trimesh(MESH.vertices, MESH.faces, process=False)
    texts = {
        ".ply": lambda path: path.write_bytes(export_ply(flat, encoding="ascii")),
        ".stl": lambda path: path.write_text(export_stl_ascii(flat)),
        ".obj": _text("v 0 0 0\nv 1 0 0\nv 0 1 .5e-1\nvn 0 0 1\nf -3//1 -2//1 -1//1\n"),
    }
    mutations = {".gltf": mutate_json, ".glb": mutate_glb}
    return Reader(
        f"mesh{suffix}", read_mesh, (write, *(texts[s] for s in [suffix] if s in texts)), mutations.get(suffix)
    )


def _rig_glb(path: Path) -> None:
    write_gltf(path, _rig(), sparse=True)


def _read_glb(path: Path) -> None:
    read_gltf(path)
    read_clips(path)


def _clip_glb(path: Path) -> None:
    write_gltf(path, _rig(), animation=Animation(_TRACK.times, np.array(WEIGHTS)))


_LINES = "".join(f"{x} {y}\n" for x, y in MARKS.points.tolist())
_TRACK = Track(("jawOpen", "b"), np.array([0, 0.1, 0.3]), np.array(WEIGHTS), np.zeros((3, 3)))
_OWN_WEIGHTS = {"schema": "caricli.weights/1", "fps": 30, "names": ["jawOpen", "b"], "weights": WEIGHTS}
_ARRAYS: dict[str, Any] = {"names": np.array(["jawOpen", "b"]), "weights": np.array(WEIGHTS), "fps": np.array(25.0)}
_STEPS: Callable[[Path], object] = lambda path: read_config(path, DeformableConfig)  # noqa: E731
_ACTIONS: Callable[[Path], object] = lambda path: read_expressions(path, ARKIT_NAMES)  # noqa: E731
_HANDLES: Callable[[Path], object] = lambda path: handle_points(load_handles(path), (), template(), False)  # noqa: E731
_TABLES = ("file,identity,BigNose\na.obj,x,0.5\nb.obj,y,-1e3\n", "file;level;Nose\na.obj;1;0,5\nb.obj;2;1\n")
_TABLE: Callable[[Path], object] = lambda path: read_labels(path, ["a.obj", "b.obj"])  # noqa: E731


def _all() -> list[Reader]:
    return [
        *map(_mesh_reader, MESH_SUFFIXES),
        Reader("rig.glb", _read_glb, (_rig_glb, _clip_glb), mutate_glb),
        Reader("rig.npz", read_rig, (lambda path: write_rig(path, _rig()),), mutate_arrays),
        Reader("face.npz", read_face, (lambda path: write_face(path, _face()),), mutate_arrays),
        Reader("names.npz", read_picture_names, (_worn,), mutate_arrays),
        Reader("worn.npz", read_face, (_worn,), mutate_arrays),
        Reader("names.txt", _read_name, (_text("anna__jawOpen__2"), _text("eyeBlink_L"))),
        Reader("loaded.npz", _load_face, (lambda path: write_face(path, _face()),), mutate_arrays),
        Reader("arrays.npz", read_npz, (lambda path: write_npz(path, _ARRAYS),), mutate_members),
        Reader("directions.npz", read_directions, (lambda path: write_directions(path, _directions()),), mutate_arrays),
        Reader("model.safetensors", _use_model, _model_seeds(), mutate_tensors),
        Reader("detector.safetensors", load_detector, (_write_detector,), mutate_tensors),
        Reader("coarse.safetensors", load_coarse, (_write_coarse,), mutate_tensors),
        Reader("sketch.safetensors", load_sketch_network, (_write_sketch_network,), mutate_tensors),
        Reader("texture.safetensors", load_texture_network, (_write_texture_network,), mutate_tensors),
        Reader("strokes.safetensors", load_strokes, (_write_stroke_network,), mutate_tensors),
        Reader("gesture.safetensors", load_gestures, (_write_gestures,), mutate_tensors),
        Reader("style.safetensors", load_style, (_write_style,), mutate_tensors),
        Reader("map.safetensors", _map_marks, (_write_map,), mutate_tensors),
        Reader("any.safetensors", read_checkpoint, (_write_map,)),
        Reader("state.pt", read_state, (_state,), mutate_members),
        Reader("dataset.npz", _read_bundle, (_dataset_bundle,), _mutate_bundle),
        Reader("pictures.npz", _read_pictures, (_pictures_bundle,), _mutate_bundle),
        Reader("sketches.npz", _read_sketches, (_sketches_bundle,), _mutate_bundle),
        Reader("textures.npz", _read_textures, (_textures_bundle,), _mutate_bundle),
        Reader("marks.json", read_landmarks, (lambda path: write_landmarks(path, MARKS),), mutate_json),
        Reader("marks.pts", read_landmarks, (lambda path: write_landmarks(path, MARKS),)),
        Reader("marks.txt", read_landmarks, (_text(_LINES),)),
        Reader("marks.npy", read_landmarks, (lambda path: write_landmarks(path, MARKS),)),
        Reader("sketch.json", read_sketch, (lambda path: write_sketch(path, _sketch()),), mutate_json),
        Reader("session.json", read_session, (lambda path: write_session(path, SESSION),), mutate_json),
        Reader("sketch.svg", read_svg, (lambda path: write_sketch(path, _sketch()), _text(SVG))),
        Reader("track.json", read_weights, (lambda path: write_weights(path, _TRACK), _json(_OWN_WEIGHTS), _mediapipe),
               mutate_json),
        Reader("track.csv", read_weights, (_live_link,)),
        Reader("track.npz", read_weights, (lambda path: write_npz(path, _ARRAYS),), mutate_arrays),
        Reader("cues.json", read_cues, (_json({"metadata": {"duration": 0.9}, "mouthCues": CUES}),), mutate_json),
        Reader("cues.tsv", read_cues, (_text("0.00\tX\n0.25\tB\n0.75\tX\n"), _text(XML))),
        Reader("picture.img", read_image, (
            _picture("PNG"), _picture("PNG", "P"), _picture("PNG", "RGBA"), _picture("JPEG"), _picture("WEBP"),
            _picture("TIFF"), _picture("TIFF", compression="tiff_lzw"), _picture("TIFF", compression="tiff_deflate"),
            _picture("TIFF", "1", compression="group4"), _picture("GIF"), _picture("TIFF", "I"),
            _picture("BMP"),
        )),
        Reader("mask.img", read_alpha, (_picture("PNG", "RGBA"), _picture("PNG", "P"), _picture("TIFF", "I"))),
        Reader("parsing.png", read_parsing, (_picture_of_eyes,)),
        Reader("legend.json", read_legend, (_json({"schema": "caricli.parsing/1", "labels": {"skin": 1}}),)),
        Reader("value.json", read_json, (_json(TREE),), mutate_json),
        Reader("settings.yaml", _STEPS, (_text("latent: 4\nlearning_rate: 1e-3\nschedule: cosine\n"),)),
        Reader("expressions.yaml", _ACTIONS, (_text("neutral: {}\nsmile: {mouthSmile: 0.5, jawOpen: 1}\n"),)),
        Reader("annotation.json", _read_annotation, (_json(ANNOTATION), _json(ANNOTATION | {"parts": PARTS})),
               mutate_json),
        Reader("handles.json", _HANDLES, (_json({"l30": [0, 0, "5%"], "17": [0.01, 0, 0]}),), mutate_json),
        Reader("labels.csv", _TABLE, tuple(map(_text, _TABLES))),
        Reader("material.txt", _read_material, (_text("mtllib a.mtl\nmap_Kd -s 1 1 1 a.png\n"),)),
    ]  # fmt: skip


READERS = {reader.name: reader for reader in _all()}


def any_reader() -> Reader:
    """What tells files by their content, with the good files of all the others."""

    def renamed(name: str, write: Callable[[Path], object]) -> Callable[[Path], object]:
        def write_here(path: Path) -> None:
            write(path.with_name(name))
            path.with_name(name).rename(path)

        return write_here

    others = [(reader.name, write) for reader in READERS.values() for write in reader.seeds]
    return Reader("any.bin", load_any, tuple(renamed(*other) for other in others))


READERS["any.bin"] = any_reader()
