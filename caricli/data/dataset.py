"""A dataset folder: a manifest, the template and shards of meshes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.errors import InputError
from caricli.io.npz import read_npz, write_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json, write_json
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

SCHEMA = "caricli.dataset/1"
SPLITS = ("train", "validation", "test")
SHARD_SIZE = 512
ALBEDO_FILE = "albedo.npz"
_COLUMNS = ("identity", "expression", "level")


@dataclass(frozen=True)
class Dataset:
    """Meshes of one topology: vertices (N, V, 3) float32; identity, expression, level (N,) int; labels by name.

    ``measures`` and ``labels`` are (N, A) with the names ``attributes``; ``factors`` holds further (N, ...) columns.
    ``splits`` maps train, validation and test to identities.
    """

    manifest: dict
    template: Template
    vertices: np.ndarray
    identity: np.ndarray
    expression: np.ndarray
    level: np.ndarray
    attributes: tuple
    measures: np.ndarray
    labels: np.ndarray
    factors: dict

    def rows(self, split):
        """(N,) bool: the meshes of a split."""
        return np.isin(self.identity, self.manifest["splits"][split])


def split_identities(identities, generator):
    """Divide identities into about 90 % training, 1 % validation and 9 % test, at least one each where possible.

    identities: sequence of distinct ints. generator: numpy Generator.
    Returns dict from split names to sorted lists.
    """
    shuffled = [int(i) for i in generator.permutation(identities)]
    count = len(shuffled)
    test = max(round(0.09 * count), 1 if count > 1 else 0)
    validation = max(round(0.01 * count), 1 if count > 2 else 0)
    parts = shuffled[test + validation :], shuffled[test : test + validation], shuffled[:test]
    return {name: sorted(part) for name, part in zip(SPLITS, parts, strict=True)}


def write_dataset(folder, template, shards, manifest):
    """Write a dataset into an empty folder, the manifest last.

    folder: Path. template: Template. shards: iterable of dicts with vertices, identity, expression, level and further
    columns, each an array with the same first dimension. manifest: callable that is called after the last shard with
    the list of shard entries and returns (dict, dict of arrays for labels.npz).
    """
    folder = Path(folder)
    arrays = {"vertices": template.vertices, "faces": template.faces, "polygons": template.polygons}
    if template.uvs is not None:
        arrays |= {"uvs": template.uvs, "uv_polygons": template.uv_polygons}
    write_npz(folder / "template.npz", arrays)
    entries = []
    for number, shard in enumerate(shards):
        name = f"shard-{number:04d}.npz"
        write_npz(folder / name, shard | {"vertices": shard["vertices"].astype(np.float32)})
        entries.append({"file": name, "count": len(shard["vertices"]), "sha256": sha256_file(folder / name)})
    value, labels = manifest(entries)
    write_npz(folder / "labels.npz", labels)
    value = {
        "schema": SCHEMA,
        "units": "m",
        "axes": "+y up, +z front",
        "topology_id": template.topology_id,
        **value,
        "annotation": template.annotation.source,
        "template": {"file": "template.npz", "sha256": sha256_file(folder / "template.npz")},
        "labels": {"file": "labels.npz", "sha256": sha256_file(folder / "labels.npz")},
        "shards": entries,
    }
    write_json(folder / "dataset.json", value)


def read_dataset(folder):
    """Read a dataset folder.

    Returns Dataset. Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    where = folder / "dataset.json"
    if folder.is_dir() and not where.exists():
        raise InputError(f"{folder}: no dataset.json in this folder: not a dataset, or its build was interrupted")
    manifest = read_json(where)
    try:
        if manifest["schema"] != SCHEMA:
            raise InputError(f"{where}: expected schema {SCHEMA!r}, found {manifest['schema']!r}")
        template = _read_template(folder, manifest)
        columns = {}
        for entry in manifest["shards"]:
            shard = _read_checked(folder, entry)
            _check_shard(shard, entry, template, folder)
            for name, column in shard.items():
                columns.setdefault(name, []).append(column)
        columns = {name: np.concatenate(parts) for name, parts in columns.items()}
        labels = _read_checked(folder, manifest["labels"])
        attributes = tuple(str(n) for n in labels["attributes"])
        expected = (len(columns["vertices"]), len(attributes))
        if labels["measures"].shape != expected or labels["labels"].shape != expected:
            raise InputError(f"{folder / 'labels.npz'}: expected {expected} measures and labels")
        known = set(np.unique(columns["identity"]).tolist())
        splits = manifest["splits"]
        if set(splits) != set(SPLITS) or sum(len(splits[s]) for s in SPLITS) != len(set().union(*splits.values())):
            raise InputError(f"{where}: 'splits' must share the identities out among {', '.join(SPLITS)}")
        if not known <= set().union(*splits.values()):
            raise InputError(f"{where}: there are identities that no split names")
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where}: not a valid dataset: {type(error).__name__} {error}") from error
    vertices, identity, expression, level = (columns.pop(name) for name in ("vertices", *_COLUMNS))
    tables = labels["measures"], labels["labels"].astype(bool)
    return Dataset(manifest, template, vertices, identity, expression, level, attributes, *tables, columns)


def read_albedos(folder):
    """The random colours that were drawn beside the meshes.

    Returns (N, S, S, 3) uint8 sRGB in the UVs of the template, the top row first. Raises InputError when the dataset
    has none, or its file is missing, damaged or not what the manifest says.
    """
    folder = Path(folder)
    where = folder / "dataset.json"
    entry = read_json(where).get("albedo")
    if entry is None:
        raise InputError(f"{where}: a dataset without albedos: build it with --albedo N")
    try:
        pictures = _read_checked(folder, entry)["albedo"]
        expected = (entry["count"], entry["size"], entry["size"], 3)
    except (KeyError, TypeError) as error:
        raise InputError(f"{where}: not a valid dataset: {type(error).__name__} {error}") from error
    if pictures.shape != expected or pictures.dtype != np.uint8:
        raise InputError(
            f"{folder / entry['file']}: expected {expected} bytes, found {pictures.shape} {pictures.dtype}"
        )
    return pictures


def _read_checked(folder, entry):
    name = entry["file"]
    if not isinstance(name, str) or Path(name).name != name:
        raise InputError(f"{folder / 'dataset.json'}: {name!r} must be a file in the dataset's own folder")
    if sha256_file(folder / name) != entry["sha256"]:
        raise InputError(f"{folder / name}: its SHA-256 is not the one in dataset.json: the file was changed")
    return read_npz(folder / name)


def _read_template(folder, manifest):
    arrays = _read_checked(folder, manifest["template"])
    count = len(arrays["vertices"])
    annotation = parse_annotation(manifest["annotation"], count, str(folder / "dataset.json"))
    uvs = (arrays.get("uvs"), arrays.get("uv_polygons"))
    template = Template(arrays["vertices"], arrays["polygons"], *uvs, annotation=annotation)
    if template.topology_id != manifest["topology_id"] or not np.array_equal(template.faces, arrays["faces"]):
        raise InputError(f"{folder / 'template.npz'}: its faces do not fit dataset.json")
    return template


def _check_shard(shard, entry, template, folder):
    where = folder / entry["file"]
    vertices = shard["vertices"]
    if vertices.ndim != 3 or vertices.shape[1:] != template.vertices.shape or len(vertices) != entry["count"]:
        expected = (entry["count"], *template.vertices.shape)
        raise InputError(f"{where}: expected vertices {expected}, found {vertices.shape}")
    if not np.isfinite(vertices).all():
        raise InputError(f"{where}: vertices must be finite")
    if any(len(column) != len(vertices) for column in shard.values()):
        raise InputError(f"{where}: its columns differ in length")
