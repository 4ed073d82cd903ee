"""A folder of sketches with all that is known of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import read_named
from caricli.data.shards import ShardForm
from caricli.errors import InputError, naming
from caricli.io.npz import take_array, write_npz
from caricli.io.outputs import write_bytes
from caricli.io.provenance import sha256_file, sha256_files
from caricli.io.strict_json import take, take_whole, write_json
from caricli.limits import MAX_SKETCH_POINTS, MAX_SKETCH_SIDE
from caricli.structures.checks import number_problem, refuse
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

SCHEMA = "caricli.sketches/1"
MANIFEST = "sketches.json"
SHARD_SIZE = 512
"""Sketches of one file of strokes."""

FORM = ShardForm(MANIFEST, SCHEMA, "sketches", "sketches", SHARD_SIZE)

KINDS = tuple(StrokeKind)

TRUTH: dict[str, tuple[str, tuple[int, ...]]] = {
    "row": ("iu", ()),
    "person": ("iu", ()),
    "expression": ("iu", ()),
    "level": ("iu", ()),
    "rotation": ("f", (3, 3)),
    "scale": ("f", ()),
    "translation": ("f", (2,)),
}
"""Columns of what is known of every sketch: kinds and shapes after the first axis."""


@dataclass(frozen=True, eq=False)
class SketchSet:
    """Sketches, and the meshes that they are of.

    folder: where they are. manifest: JSON object; its splits map SPLITS to people. side: pixels of every canvas.
    truth: columns (N, ...) by the names of TRUTH: ``row`` of the dataset, ``person``, ``expression``, ``level``, and
    the camera that the exact lines were seen with, before a hand bent them.
    """

    folder: Path
    manifest: dict[str, Any]
    side: int
    truth: dict[str, np.ndarray]

    def sketches(self, shard: int) -> list[Sketch]:
        """All Sketches of a file of strokes. Raises InputError when it is missing or damaged."""
        arrays = read_named(self.folder, self.manifest["shards"][shard], MANIFEST)
        with naming(self.folder / self.manifest["shards"][shard]["file"]):
            return _unpacked(arrays, self.manifest["curves"], self.side)

    @property
    def missing(self) -> int:
        """How many pictures of sketches are not there."""
        return sum(not picture.is_file() for picture in _files(self.folder, self.manifest["count"]))

    @property
    def changed(self) -> bool:
        """Whether pictures, which are all there, are others than the manifest says, if it says it."""
        digest = self.manifest.get("sha256")
        return digest is not None and digest != sha256_files(_files(self.folder, self.manifest["count"]))

    def rows_of(self, split: str) -> np.ndarray:
        """Numbers of the sketches of a split's people."""
        return np.flatnonzero(np.isin(self.truth["person"], self.manifest["splits"][split]))


def picture_name(number: int) -> str:
    """The file of a sketch's picture in its folder."""
    return f"pictures/{number:06d}.png"


def _files(folder: Path, count: int) -> list[Path]:
    """The pictures of all sketches."""
    return [folder / picture_name(number) for number in range(count)]


class SketchWriter:
    """Writes sketches into an empty folder, the manifest last: without it the folder is none."""

    def __init__(self, folder: Path, curves: Sequence[str]) -> None:
        """folder: Path. curves: names of all that strokes may draw."""
        self.folder = folder
        self.curves = tuple(curves)
        self.shards: list[dict[str, Any]] = []
        self.count = 0
        self.waiting: list[Sketch] = []
        self.rows: list[Mapping[str, Any]] = []
        (folder / "pictures").mkdir(parents=True)

    def add(self, sketch: Sketch, picture: bytes, truth: Mapping[str, Any]) -> None:
        """Write one sketch. picture: PNG. truth: values by the names of TRUTH."""
        write_bytes(self.folder / picture_name(self.count), picture)
        self.waiting.append(sketch)
        self.rows.append(truth)
        self.count += 1
        if len(self.waiting) == SHARD_SIZE:
            self._flush()

    def _flush(self) -> None:
        name = f"strokes-{len(self.shards):04d}.npz"
        rows = self.rows[-len(self.waiting) :]
        kinds = {"f": np.float64, "iu": np.int32}
        truth = {key: np.array([row[key] for row in rows], kinds[kind]) for key, (kind, _) in TRUTH.items()}
        write_npz(self.folder / name, _packed(self.waiting, self.curves) | truth)
        self.shards.append({"file": name, "count": len(rows), "sha256": sha256_file(self.folder / name)})
        self.waiting = []

    def finish(self, manifest: Mapping[str, Any]) -> None:
        """Write what is left and the manifest. manifest: its entries beside those that every folder of sketches has."""
        if self.waiting:
            self._flush()
        value = {"schema": SCHEMA, "count": self.count, **manifest, "curves": self.curves, "shards": self.shards}
        write_json(self.folder / MANIFEST, value | {"sha256": sha256_files(_files(self.folder, self.count))})


def read_sketch_set(folder: Path) -> SketchSet:
    """Read a folder of sketches; strokes are read when they are asked for.

    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    manifest = FORM.load_manifest(folder)
    with naming(folder / MANIFEST):
        side = take_whole(manifest, "side", 1, MAX_SKETCH_SIDE)
        if not all(isinstance(name, str) for name in take(manifest, "curves", list)):
            raise InputError("curves: expected names, found others")
    parts = []
    for shard in manifest["shards"]:
        arrays = read_named(folder, shard, MANIFEST)
        with naming(folder / shard["file"]):
            columns = {
                key: take_array(arrays, key, kind, (shard["count"], *form)) for key, (kind, form) in TRUTH.items()
            }
            refuse(*(number_problem(key, column) for key, column in columns.items()))
            parts.append(columns)
    truth = {key: np.concatenate([part[key] for part in parts]) for key in TRUTH}
    return SketchSet(folder, manifest, side, truth)


def _packed(sketches: Sequence[Sketch], curves: Sequence[str]) -> dict[str, np.ndarray]:
    strokes = [stroke for sketch in sketches for stroke in sketch.strokes]
    flat = [np.ones(len(stroke.points)) if stroke.pressure is None else stroke.pressure for stroke in strokes]
    return {
        "strokes": np.array([len(sketch.strokes) for sketch in sketches], np.int32),
        "lengths": np.array([len(stroke.points) for stroke in strokes], np.int32),
        "kinds": np.array([KINDS.index(stroke.kind) for stroke in strokes], np.uint8),
        "curves": np.array([-1 if s.curve is None else curves.index(s.curve) for s in strokes], np.int16),
        "widths": np.array([0.0 if stroke.width is None else stroke.width for stroke in strokes], np.float32),
        "points": np.concatenate([stroke.points for stroke in strokes]).astype(np.float32),
        "pressure": np.rint(255 * np.concatenate(flat)).astype(np.uint8),
    }


def _unpacked(arrays: Mapping[str, np.ndarray], curves: Sequence[str], side: int) -> list[Sketch]:
    # Numbers without a sign would become fractions as soon as they meet others.
    counts = take_array(arrays, "strokes", "iu", (None,)).astype(np.int64)
    lengths = take_array(arrays, "lengths", "iu", (None,)).astype(np.int64)
    total = len(lengths)
    kinds = take_array(arrays, "kinds", "iu", (total,)).astype(np.int64)
    numbers = take_array(arrays, "curves", "iu", (total,)).astype(np.int64)
    widths = take_array(arrays, "widths", "f", (total,))
    sizes = np.concatenate([counts, lengths])
    if not ((sizes >= 1) & (sizes <= MAX_SKETCH_POINTS)).all() or counts.sum() != total:
        raise InputError("expected strokes and points for every sketch, found others")
    points = take_array(arrays, "points", "f", (int(lengths.sum()), 2))
    pressure = take_array(arrays, "pressure", "iu", (len(points),))
    if kinds.max() >= len(KINDS) or kinds.min() < 0 or numbers.max() >= len(curves) or numbers.min() < -1:
        raise InputError("expected known kinds and curves, found others")
    ends = np.cumsum(lengths)
    strokes = [
        Stroke(
            points[end - length : end],
            KINDS[kind],
            None if curve < 0 else curves[curve],
            pressure[end - length : end] / 255,
            float(width) or None,
        )
        for end, length, kind, curve, width in zip(ends, lengths, kinds, numbers, widths, strict=True)
    ]
    last = np.cumsum(counts)
    return [Sketch(tuple(strokes[end - count : end]), (side, side)) for end, count in zip(last, counts, strict=True)]
