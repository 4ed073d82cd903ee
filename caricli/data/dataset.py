"""A dataset folder: a manifest, the template and shards of meshes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, naming
from caricli.io.npz import read_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

SCHEMA = "caricli.dataset/1"
SPLITS = ("train", "validation", "test")
TEST_SHARE = 0.09
VALIDATION_SHARE = 0.01
"""Of the people; the others are trained with."""

MANIFEST = "dataset.json"
ALBEDO_FILE = "albedo.npz"


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


def split_identities(identities: Sequence[int], generator: np.random.Generator) -> dict[str, list[int]]:
    """Divide people into about 90 % training, 1 % validation and 9 % test, at least one each where possible.

    identities: distinct numbers.
    Returns sorted lists by the names of SPLITS.
    """
    shuffled = [int(i) for i in generator.permutation(identities)]
    count = len(shuffled)
    test = max(round(TEST_SHARE * count), 1 if count > 1 else 0)
    validation = max(round(VALIDATION_SHARE * count), 1 if count > 2 else 0)
    parts = (shuffled[test + validation :], shuffled[test : test + validation], shuffled[:test])
    return {name: sorted(part) for name, part in zip(SPLITS, parts, strict=True)}


def read_dataset(folder: Path) -> Dataset:
    """Read a dataset folder.

    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    where = folder / MANIFEST
    if folder.is_dir() and not where.exists():
        raise InputError(f"{folder}: no {MANIFEST} in this folder: not a dataset, or its build was interrupted")
    manifest = read_json(where)
    try:
        return _read_parts(folder, manifest)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where}: not a valid dataset: {type(error).__name__} {error}") from error


def read_albedos(folder: Path) -> np.ndarray:
    """The random colours that were drawn beside the meshes.

    Returns (N, S, S, 3) uint8 sRGB in the UVs of the template, the top row first. Raises InputError when the dataset
    has none, or its file is missing, damaged or not what the manifest says.
    """
    folder = Path(folder)
    where = folder / MANIFEST
    entry = read_json(where).get("albedo")
    if entry is None:
        raise InputError(f"{where}: a dataset without albedos: build it with --albedo N")
    try:
        pictures = _read_checked(folder, entry)["albedo"]
        expected = (entry["count"], entry["size"], entry["size"], 3)
    except (KeyError, TypeError) as error:
        raise InputError(f"{where}: not a valid dataset: {type(error).__name__} {error}") from error
    if pictures.shape != expected or pictures.dtype != np.uint8:
        given = f"{pictures.shape} {pictures.dtype}"
        raise InputError(f"{folder / entry['file']}: expected {expected} bytes, found {given}")
    return pictures


def _read_parts(folder: Path, manifest: dict[str, Any]) -> Dataset:
    with naming(folder / MANIFEST):
        if manifest["schema"] != SCHEMA:
            raise InputError(f"expected schema {SCHEMA!r}, found {manifest['schema']!r}")
    template = _read_template(folder, manifest)
    columns = _read_columns(folder, manifest, template)
    labels = _read_checked(folder, manifest["labels"])
    attributes = tuple(str(name) for name in labels["attributes"])
    expected = (len(columns["vertices"]), len(attributes))
    if labels["measures"].shape != expected or labels["labels"].shape != expected:
        raise InputError(f"{folder / 'labels.npz'}: expected {expected} measures and labels")
    with naming(folder / MANIFEST):
        _check_splits(manifest["splits"], columns["identity"])
    return Dataset(
        manifest=manifest,
        template=template,
        vertices=columns.pop("vertices"),
        identity=columns.pop("identity"),
        expression=columns.pop("expression"),
        level=columns.pop("level"),
        attributes=attributes,
        measures=labels["measures"],
        labels=labels["labels"].astype(bool),
        factors=columns,
    )


def _read_columns(folder: Path, manifest: Mapping[str, Any], template: Template) -> dict[str, np.ndarray]:
    parts: dict[str, list[np.ndarray]] = {}
    for entry in manifest["shards"]:
        shard = _read_checked(folder, entry)
        with naming(folder / entry["file"]):
            _check_shard(shard, entry["count"], template)
        for name, column in shard.items():
            parts.setdefault(name, []).append(column)
    return {name: np.concatenate(columns) for name, columns in parts.items()}


def _check_splits(splits: Mapping[str, list[int]], identity: np.ndarray) -> None:
    complete = set(splits) == set(SPLITS)
    named = set().union(*splits.values())
    if not complete or sum(len(splits[split]) for split in SPLITS) != len(named):
        raise InputError(f"'splits' must share the identities out among {', '.join(SPLITS)}")
    if not set(np.unique(identity).tolist()) <= named:
        raise InputError("there are identities that no split names")


def _read_checked(folder: Path, entry: Mapping[str, Any]) -> dict[str, np.ndarray]:
    name = entry["file"]
    if not isinstance(name, str) or Path(name).name != name:
        raise InputError(f"{folder / MANIFEST}: {name!r} must be a file in the dataset's own folder")
    if sha256_file(folder / name) != entry["sha256"]:
        raise InputError(f"{folder / name}: its SHA-256 is not the one in {MANIFEST}: the file was changed")
    return read_npz(folder / name)


def _read_template(folder: Path, manifest: Mapping[str, Any]) -> Template:
    arrays = _read_checked(folder, manifest["template"])
    annotation = parse_annotation(manifest["annotation"], len(arrays["vertices"]), str(folder / MANIFEST))
    uvs = arrays.get("uvs")
    uv_polygons = arrays.get("uv_polygons")
    with naming(folder / "template.npz"):
        template = Template(arrays["vertices"], arrays["polygons"], uvs, uv_polygons, annotation=annotation)
        if template.topology_id != manifest["topology_id"] or not np.array_equal(template.faces, arrays["faces"]):
            raise InputError(f"its faces do not fit {MANIFEST}")
    return template


def _check_shard(shard: Mapping[str, np.ndarray], count: int, template: Template) -> None:
    vertices = shard["vertices"]
    expected = (count, *template.vertices.shape)
    if vertices.shape != expected:
        raise InputError(f"expected vertices {expected}, found {vertices.shape}")
    if not np.isfinite(vertices).all():
        raise InputError("vertices must be finite")
    if any(len(column) != len(vertices) for column in shard.values()):
        raise InputError("its columns differ in length")
