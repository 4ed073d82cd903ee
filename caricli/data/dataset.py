"""A dataset folder: a manifest, the template and shards of meshes."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.npz import read_npz, take_array
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json, take, take_whole
from caricli.limits import MAX_DATASET_BYTES, MAX_VERTICES
from caricli.structures.checks import coordinate_problem, number_problem, refuse
from caricli.template.annotation import parse_annotation
from caricli.template.own_parts import parts_from_arrays
from caricli.template.template import Template

SCHEMA = "caricli.dataset/1"
SPLITS = ("train", "validation", "test")
TEST_SHARE = 0.09
VALIDATION_SHARE = 0.01
"""Of the people; the others are trained with."""

MANIFEST = "dataset.json"

_KINDS = {MANIFEST: "a dataset"} | {
    f"{kind}.json": f"a folder of `caricli dataset {kind}`" for kind in ("pictures", "sketches", "textures")
}
"""What folders of data are, by their manifests."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """Meshes of one topology.

    manifest: JSON object; its splits map SPLITS to identities. vertices: (N, V, 3) float32, metres.
    identity, expression, level: (N,) int. attributes: A names. measures: (N, A). labels: (N, A) bool.
    factors: further columns (N, ...) by name.
    """

    manifest: dict[str, Any]
    template: Template
    vertices: np.ndarray
    identity: np.ndarray
    expression: np.ndarray
    level: np.ndarray
    attributes: tuple[str, ...]
    measures: np.ndarray
    labels: np.ndarray
    factors: dict[str, np.ndarray]

    def rows(self, split: str) -> np.ndarray:
        """(N,) bool: the meshes of a split."""
        return np.isin(self.identity, self.manifest["splits"][split])

    @property
    def regular(self) -> np.ndarray:
        """(N,) bool: the meshes that are not exaggerated, neither by a level nor by changes of parts."""
        changed = self.factors["kind"] > 0 if "kind" in self.factors else np.zeros(len(self.level), bool)
        return (self.level == 1) & ~changed


def split_identities(identities: Sequence[int], generator: np.random.Generator) -> dict[str, list[int]]:
    """Divide people into about 90 % training, 1 % validation and 9 % test, at least one each where possible.

    identities: distinct numbers.
    Returns sorted lists by the names of SPLITS.
    """
    return _divided([int(i) for i in generator.permutation(identities)])


def split_names(names: Sequence[str], seed: int) -> dict[str, list[int]]:
    """Divide people as ``split_identities`` does, but in the order of a hash of seed and name: when somebody comes in,
    at most one other goes from each split to its neighbour, and nobody between test and training.

    names: N, distinct. Returns sorted lists of their numbers by the names of SPLITS.
    """
    hashes = [hashlib.sha256(f"{seed} {name}".encode()).hexdigest() for name in names]
    return _divided(sorted(range(len(names)), key=hashes.__getitem__))


def _divided(order: Sequence[int]) -> dict[str, list[int]]:
    """Numbers in SPLITS, those that come first in the last."""
    count = len(order)
    test = max(round(TEST_SHARE * count), 1 if count > 1 else 0)
    validation = max(round(VALIDATION_SHARE * count), 1 if count > 2 else 0)
    parts = (order[test + validation :], order[test : test + validation], order[:test])
    return {name: sorted(part) for name, part in zip(SPLITS, parts, strict=True)}


def read_dataset(folder: Path) -> Dataset:
    """Read a dataset folder.

    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    return _read_parts(folder, _read_manifest(folder))


def read_manifest(folder: Path, name: str, schema: str, kind: str) -> dict[str, Any]:
    """The manifest of a folder of data, with its splits of people. kind: what the folder is to be, for messages.

    Raises InputError when it is missing, damaged or of another schema.
    """
    where = folder / name
    if folder.is_dir() and not where.exists():
        other = next((_KINDS[manifest] for manifest in _KINDS if (folder / manifest).exists()), None)
        if other is not None:
            raise InputError(f"{folder}: expected {kind}, found {other}")
        raise InputError(f"{folder}: no {name} in this folder: not {kind}, or its making was stopped")
    manifest = read_json(where)
    with naming(where):
        given = manifest.get("schema") if isinstance(manifest, dict) else None
        if given != schema:
            raise InputError(f"expected schema {schema!r}, found {shown(given, 60)!r}")
        splits = take(manifest, "splits", dict)
        if set(splits) != set(SPLITS) or not all(map(_are_people, splits.values())):
            raise InputError(f"splits: expected lists of people for {', '.join(SPLITS)}, found others")
    return manifest


def read_named(folder: Path, entry: Mapping[str, Any], manifest: str) -> dict[str, np.ndarray]:
    """The arrays of the file that an entry of a folder's manifest names. manifest: its own file's name.

    Raises InputError where that is no file of the folder, or its bytes are others than there.
    """
    name = entry.get("file")
    if not isinstance(name, str) or Path(name).name != name:
        raise InputError(f"{folder / manifest}: expected a file of its own folder, found {shown(name, 60)!r}")
    if sha256_file(folder / name) != entry.get("sha256"):
        raise InputError(f"{folder / name}: its SHA-256 is not the one in {manifest}: the file was changed")
    return read_npz(folder / name)


def _read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest, with all that every dataset has in it."""
    manifest = read_manifest(folder, MANIFEST, SCHEMA, "a dataset")
    with naming(folder / MANIFEST):
        for key, kind in {"topology_id": str, "annotation": dict, "template": dict, "labels": dict}.items():
            take(manifest, key, kind)
        for shard in take(manifest, "shards", list):
            if not isinstance(shard, dict):
                raise InputError(f"shards: expected objects, found {type(shard).__name__}")
            take_whole(shard, "count", 1, MAX_VERTICES)
        files = [entry.get("file") for entry in manifest["shards"]]
        if not files or len({*map(str, files)}) < len(files):
            raise InputError("shards: expected at least one, each once, found others")
    return manifest


def _are_people(numbers: Any) -> bool:
    """Whether a JSON value is a list of people's numbers."""
    return isinstance(numbers, list) and all(type(number) is int and abs(number) < 2**62 for number in numbers)


def _read_parts(folder: Path, manifest: dict[str, Any]) -> Dataset:
    template = _read_template(folder, manifest)
    columns = _read_columns(folder, manifest, template)
    with naming(folder / MANIFEST):
        _check_splits(manifest["splits"], columns["identity"])
    labels = read_named(folder, manifest["labels"], MANIFEST)
    with naming(folder / manifest["labels"]["file"]):
        attributes = tuple(take_array(labels, "attributes", "U", (None,)).tolist())
        shape = (len(columns["vertices"]), len(attributes))
        measures = take_array(labels, "measures", "fiu", shape)
        refuse(number_problem("measures", measures))
        marked = take_array(labels, "labels", "biu", shape).astype(bool)
    return Dataset(
        manifest=manifest,
        template=template,
        vertices=columns.pop("vertices"),
        identity=columns.pop("identity"),
        expression=columns.pop("expression"),
        level=columns.pop("level"),
        attributes=attributes,
        measures=measures,
        labels=marked,
        factors=columns,
    )


def _read_columns(folder: Path, manifest: Mapping[str, Any], template: Template) -> dict[str, np.ndarray]:
    total = sum(entry["count"] for entry in manifest["shards"]) * template.vertices.size * 4
    if total > MAX_DATASET_BYTES:
        raise InputError(f"{folder / MANIFEST}: expected at most {MAX_DATASET_BYTES} bytes of meshes, found {total}")
    parts: dict[str, list[np.ndarray]] = {}
    for number, entry in enumerate(manifest["shards"]):
        shard = read_named(folder, entry, MANIFEST)
        with naming(folder / entry["file"]):
            _check_shard(shard, entry["count"], template)
            if number and {name: _form(column) for name, column in shard.items()} != {
                name: _form(columns[0]) for name, columns in parts.items()
            }:
                raise InputError("expected the columns of the first shard, found others")
        for name, column in shard.items():
            parts.setdefault(name, []).append(column)
    return {name: np.concatenate(columns) for name, columns in parts.items()}


def _form(column: np.ndarray) -> tuple:
    """What the columns of a name have in common in all shards; texts may differ in length."""
    return column.dtype.kind, column.shape[1:]


def _check_splits(splits: Mapping[str, list[int]], identity: np.ndarray) -> None:
    named = set().union(*splits.values())
    if sum(len(splits[split]) for split in SPLITS) != len(named):
        raise InputError(f"splits: expected everybody in one of {', '.join(SPLITS)}, found some in two")
    if not set(np.unique(identity).tolist()) <= named:
        raise InputError("splits: expected everybody of the meshes in one, found some in none")


def _read_template(folder: Path, manifest: Mapping[str, Any]) -> Template:
    arrays = read_named(folder, manifest["template"], MANIFEST)
    with naming(folder / manifest["template"]["file"]):
        vertices = take_array(arrays, "vertices", "f", (None, 3))
        faces = take_array(arrays, "faces", "iu", (None, 3))
        polygons = take_array(arrays, "polygons", "iu", (None, None))
    annotation = parse_annotation(manifest["annotation"], len(vertices), str(folder / MANIFEST))
    with naming(folder / manifest["template"]["file"]):
        template = Template(vertices, polygons, arrays.get("uvs"), arrays.get("uv_polygons"), annotation=annotation)
        if template.topology_id != manifest["topology_id"] or not np.array_equal(template.faces, faces):
            raise InputError(f"expected the faces that {MANIFEST} tells, found others")
        return replace(template, parts=parts_from_arrays(arrays, template))


def _check_shard(shard: Mapping[str, np.ndarray], count: int, template: Template) -> None:
    vertices = take_array(shard, "vertices", "f", (count, *template.vertices.shape))
    refuse(coordinate_problem("vertices", vertices))
    for name in ("identity", "expression", "level"):
        refuse(number_problem(name, take_array(shard, name, "iu", (count,))))
    for name, column in shard.items():
        if not column.ndim or len(column) != count:
            raise InputError(f"{shown(name, 40)}: expected {count} rows as there are vertices, found {column.shape}")
        if column.dtype.kind == "f":
            refuse(number_problem(shown(name, 40), column))
