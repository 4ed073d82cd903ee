"""Anyone's registered meshes as a dataset."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.data.dataset import split_identities
from caricli.data.write_dataset import SHARD_SIZE, DatasetWriter
from caricli.errors import InputError, naming
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.io.files import read_text
from caricli.io.mesh import mesh_files, read_mesh
from caricli.io.strict_json import read_json
from caricli.limits import MAX_DATASET_BYTES
from caricli.structures import Mesh
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

MAX_CSV_BYTES = 2**26
_OWN_COLUMNS = ("file", "identity")


@dataclass(frozen=True, eq=False)
class Labels:
    """What a table says about N files.

    identities: (N,) int32, who each of them is. names: (A,) of the attributes. values: (N, A) float32.
    """

    identities: np.ndarray
    names: np.ndarray
    values: np.ndarray


def import_dataset(
    mesh_folder: Path,
    folder: Path,
    annotation_path: Path,
    labels_path: Path | None = None,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the meshes of a folder (``mesh_files``), in the order of their names, into an empty dataset folder.

    mesh_folder: holds files of one topology in metres, +y up, +z front. annotation_path: JSON for ``parse_annotation``.
    labels_path: CSV with a column ``file``, maybe ``identity``, and numeric label columns. seed: of the split.
    progress: called with the number of files that are read and their total.
    Returns the number of meshes. Raises InputError.
    """
    files = mesh_files(mesh_folder)
    if len(files) < 2:
        raise InputError(f"{mesh_folder}: expected at least two OBJ files or other meshes, found {len(files)}")
    first = read_mesh(files[0])
    if len(files) * first.vertices.size * 4 > MAX_DATASET_BYTES:
        raise InputError(f"{mesh_folder}: {len(files)} meshes of {len(first.vertices)} vertices do not fit in memory")
    shapes = np.empty((len(files), *first.vertices.shape), dtype=np.float32)
    for number, path in enumerate(files):
        shapes[number] = _vertices_like(path, first, files[0].name)
        progress(number + 1, len(files))
    annotation = parse_annotation(read_json(annotation_path), len(first.vertices), str(annotation_path))
    mean = shapes.mean(0, dtype=float)
    template = Template(mean, first.polygons, first.uvs, first.uv_polygons, annotation=annotation)
    labels = read_labels(labels_path, [path.name for path in files])
    splits = split_identities(np.unique(labels.identities).tolist(), np.random.default_rng(seed))
    flipped = np.mean([flipped_triangles(shape, template.gradients).mean() for shape in shapes])
    writer = DatasetWriter(folder, template)
    for start in range(0, len(files), SHARD_SIZE):
        writer.add_shard(_columns(shapes, labels, files, slice(start, start + SHARD_SIZE)))
    manifest = {"count": len(files), "seed": seed, "flipped": float(flipped), "splits": splits}
    writer.finish(manifest, {"attributes": labels.names, "measures": labels.values, "labels": labels.values > 0})
    return len(files)


def _vertices_like(path: Path, first: Mesh, name: str) -> np.ndarray:
    """The vertices of a file, whose topology must be that of the first one, called name."""
    mesh = read_mesh(path)
    with naming(path):
        if mesh.polygons.shape != first.polygons.shape or len(mesh.vertices) != len(first.vertices):
            expected = f"{len(first.vertices)} vertices, {len(first.polygons)} polygons"
            given = f"{len(mesh.vertices)} and {len(mesh.polygons)}"
            raise InputError(f"expected the topology of {name} ({expected}), found {given}")
        if not np.array_equal(mesh.polygons, first.polygons):
            raise InputError(f"its faces are not those of {name}")
    return mesh.vertices


def _columns(shapes: np.ndarray, labels: Labels, files: Sequence[Path], rows: slice) -> dict[str, np.ndarray]:
    zeros = np.zeros(len(shapes[rows]), dtype=np.int32)
    return {
        "vertices": shapes[rows],
        "identity": labels.identities[rows],
        "expression": zeros,
        "level": zeros,
        "file": np.array([path.name for path in files[rows]]),
    }


def read_labels(path: Path | None, files: Sequence[str]) -> Labels:
    """Read the CSV with a row for every file; without one, every mesh is a person.

    files: (N,) names. Raises InputError.
    """
    if path is None:
        count = len(files)
        return Labels(np.arange(count, dtype=np.int32), np.array([], dtype="<U1"), np.zeros((count, 0), np.float32))
    text = read_text(path, MAX_CSV_BYTES, "a CSV file").removeprefix("\ufeff")
    with naming(path):
        try:
            header, *lines = csv.reader(io.StringIO(text))
        except (csv.Error, ValueError) as error:
            raise InputError(f"expected a CSV, found {error}") from None
        if "file" not in header or len(set(header)) < len(header):
            raise InputError("expected a CSV with a column 'file' and no column twice")
        return _labels(header, lines, files)


def _labels(header: list[str], lines: list[list[str]], files: Sequence[str]) -> Labels:
    names = [name for name in header if name not in _OWN_COLUMNS]
    people: dict[str, str] = {}
    values: dict[str, list[float]] = {}
    for number, line in enumerate(lines, 2):
        if not line:
            continue
        with naming(f"line {number}"):
            if len(line) != len(header):
                raise InputError(f"expected {len(header)} columns, found {len(line)}")
            row = dict(zip(header, line, strict=True))
            file = row["file"]
            if file in values:
                raise InputError(f"{file!r} comes twice")
            people[file] = row.get("identity", file)
            values[file] = _numbers([row[name] for name in names])
    missing = [file for file in files if file not in values]
    if missing:
        raise InputError(f"no row for {missing[0]} ({len(missing)} files without one)")
    numbers = {person: k for k, person in enumerate(dict.fromkeys(people[file] for file in files))}
    identities = np.array([numbers[people[file]] for file in files], dtype=np.int32)
    return Labels(identities, np.array(names, dtype=str), np.array([values[file] for file in files], np.float32))


def _numbers(texts: list[str]) -> list[float]:
    try:
        numbers = [float(text) for text in texts]
    except ValueError:
        raise InputError("expected a number in every label column") from None
    if not (np.abs(numbers) <= np.finfo(np.float32).max).all():
        raise InputError("labels must be finite and fit single precision")
    return numbers
