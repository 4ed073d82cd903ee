"""Anyone's registered meshes as a dataset."""

import csv
import io
from pathlib import Path

import numpy as np

from caricli.data.dataset import SHARD_SIZE, split_identities, write_dataset
from caricli.errors import InputError
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.io.files import read_text
from caricli.io.obj import read_obj
from caricli.io.strict_json import read_json
from caricli.limits import MAX_NPZ_BYTES
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template


def import_dataset(obj_folder, folder, annotation_path, labels_path=None, seed=0, progress=lambda done, total: None):
    """Write the OBJ files of a folder, in the order of their names, into an empty dataset folder.

    obj_folder: holds *.obj of one topology in metres, +y up, +z front. folder: Path. annotation_path: JSON, see
    ``parse_annotation``. labels_path: CSV with a column ``file``, maybe ``identity``, and numeric label columns.
    seed: of the split.
    Returns the number of meshes. Raises InputError.
    """
    if not Path(obj_folder).is_dir():
        raise InputError(f"{obj_folder}: expected a folder of OBJ files")
    files = sorted(path for path in Path(obj_folder).iterdir() if path.suffix.lower() == ".obj")
    if len(files) < 2:
        raise InputError(f"{obj_folder}: expected at least two OBJ files, found {len(files)}")
    first = read_obj(files[0])
    if len(files) * first.vertices.size * 4 > MAX_NPZ_BYTES * 8:
        raise InputError(f"{obj_folder}: {len(files)} meshes of {len(first.vertices)} vertices do not fit in memory")
    shapes = np.empty((len(files), *first.vertices.shape), dtype=np.float32)
    for number, path in enumerate(files):
        mesh = read_obj(path)
        if mesh.polygons.shape != first.polygons.shape or len(mesh.vertices) != len(first.vertices):
            raise InputError(
                f"{path}: expected the topology of {files[0].name} ({len(first.vertices)} vertices, "
                f"{len(first.polygons)} polygons), found {len(mesh.vertices)} and {len(mesh.polygons)}"
            )
        if not np.array_equal(mesh.polygons, first.polygons):
            raise InputError(f"{path}: its faces are not those of {files[0].name}")
        shapes[number] = mesh.vertices
        progress(number + 1, len(files))
    annotation = parse_annotation(read_json(annotation_path), len(first.vertices), str(annotation_path))
    mean = shapes.mean(0, dtype=float)
    template = Template(mean, first.polygons, first.uvs, first.uv_polygons, annotation=annotation)
    identities, names, values = _read_labels(labels_path, files)

    def shards():
        for start in range(0, len(files), SHARD_SIZE):
            rows = slice(start, start + SHARD_SIZE)
            zeros = np.zeros(len(shapes[rows]), dtype=np.int32)
            yield {
                "vertices": shapes[rows],
                "identity": identities[rows],
                "expression": zeros,
                "level": zeros,
                "file": np.array([path.name for path in files[rows]]),
            }

    def manifest(entries):
        splits = split_identities(np.unique(identities).tolist(), np.random.default_rng(seed))
        flipped = np.mean([flipped_triangles(shape, template.gradients).mean() for shape in shapes])
        value = {"count": len(files), "seed": seed, "flipped": float(flipped), "splits": splits}
        return value, {"attributes": names, "measures": values, "labels": values > 0}

    write_dataset(folder, template, shards(), manifest)
    return len(files)


def _read_labels(path, files):
    """Identities (N,), attribute names (A,) and values (N, A) of a CSV; without one, every mesh is a person."""
    count = len(files)
    if path is None:
        return np.arange(count, dtype=np.int32), np.array([], dtype="<U1"), np.zeros((count, 0), np.float32)
    text = read_text(path, 2**26, "a CSV file").removeprefix("\ufeff")
    try:
        header, *lines = csv.reader(io.StringIO(text))
    except (csv.Error, ValueError) as error:
        raise InputError(f"{path}: expected a CSV, found {error}") from None
    if "file" not in header or len(set(header)) < len(header):
        raise InputError(f"{path}: expected a CSV with a column 'file' and no column twice")
    names = [name for name in header if name not in ("file", "identity")]
    rows = {}
    for number, line in enumerate(lines, 2):
        if not line:
            continue
        if len(line) != len(header):
            raise InputError(f"{path}: line {number}: expected {len(header)} columns, found {len(line)}")
        row = dict(zip(header, line, strict=True))
        if row["file"] in rows:
            raise InputError(f"{path}: line {number}: {row['file']!r} comes twice")
        try:
            values = [float(row[name]) for name in names]
        except ValueError:
            raise InputError(f"{path}: line {number}: expected a number in every label column") from None
        if not (np.abs(values) <= np.finfo(np.float32).max).all():
            raise InputError(f"{path}: line {number}: labels must be finite and fit single precision")
        rows[row["file"]] = row.get("identity", row["file"]), values
    missing = [f.name for f in files if f.name not in rows]
    if missing:
        raise InputError(f"{path}: no row for {missing[0]} ({len(missing)} files without one)")
    people = {person: k for k, person in enumerate(dict.fromkeys(rows[f.name][0] for f in files))}
    identities = np.array([people[rows[f.name][0]] for f in files], dtype=np.int32)
    return identities, np.array(names or [], dtype=str), np.array([rows[f.name][1] for f in files], np.float32)
