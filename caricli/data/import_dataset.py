"""Anyone's registered meshes as a dataset."""

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from caricli.data.alike import check_alike, check_own
from caricli.data.check_head import check_head
from caricli.data.dataset import split_names
from caricli.data.labels import read_labels
from caricli.data.units import UNITS, measured_unit
from caricli.data.write_dataset import SHARD_SIZE, DatasetWriter
from caricli.errors import InputError, naming, shown
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.uvs_beyond import uvs_beyond
from caricli.io.files import is_utf8
from caricli.io.meshes.mesh import is_mesh_file, mesh_files, read_mesh
from caricli.io.npz import npz_holds
from caricli.io.strict_json import read_json
from caricli.limits import MAX_DATASET_BYTES
from caricli.structures import Mesh
from caricli.template.annotation import check_keys, parse_annotation
from caricli.template.own_parts import read_own_parts
from caricli.template.template import Template


@dataclass(frozen=True)
class ImportSettings:
    """unit: that the files are in, of UNITS, or None to measure it. seed: of the split."""

    unit: str | None = None
    seed: int = 0


@dataclass(frozen=True)
class ImportSummary:
    """meshes, people, expressions: how many. unit: of UNITS, that the files are in. height: metres, the usual one.
    notes: what is worth knowing besides, a line each."""

    meshes: int
    people: int
    expressions: int
    unit: str
    height: float
    notes: tuple[str, ...] = ()

    def describe(self) -> str:
        """What is printed of it."""
        who = f"people {self.people}, expressions {self.expressions}"
        return f"{self.meshes} meshes, {who}, {self.height:.3f} m high, taken as given in {self.unit}"


def import_dataset(
    mesh_folder: Path,
    folder: Path,
    annotation_path: Path,
    labels_path: Path | None = None,
    settings: ImportSettings = ImportSettings(),  # noqa: B008 (frozen)
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> ImportSummary:
    """Write the meshes of a folder (``mesh_files``), in the order of their names, into an empty dataset folder.

    mesh_folder: holds files of one topology, +y up, +z front, no STL. annotation_path: JSON for ``parse_annotation``;
    parts that it names fit the first mesh.
    labels_path: CSV with a column ``file``, maybe ``identity``, ``expression`` and ``level``, and numeric label
    columns; without one the names of the files say these (``read_mesh_name``). settings: ImportSettings.
    progress: called with the number of files that are read and their total.
    Returns ImportSummary. Raises InputError.
    """
    files = _files(mesh_folder)
    first, shapes = _read_meshes(files, progress)
    check_alike(files, shapes)
    heights = np.ptp(shapes[..., 1], axis=1)
    with naming(mesh_folder):
        unit = settings.unit or measured_unit(heights)
    shapes *= np.float32(UNITS[unit])
    given = read_json(annotation_path)
    annotation = parse_annotation(given, len(first.vertices), str(annotation_path))
    with naming(annotation_path):
        check_keys(given)
    mean = shapes.mean(0, dtype=float)
    template = Template(mean, first.polygons, first.uvs, first.uv_polygons, annotation=annotation)
    check_head(template, mesh_folder, annotation_path)
    parts = read_own_parts(template, annotation_path, np.asarray(first.vertices, float) * UNITS[unit], UNITS[unit])
    template = replace(template, parts=parts)
    with naming(labels_path or mesh_folder):
        labels = read_labels(labels_path, [path.name for path in files])
    check_own(files, shapes, [name.person for name in labels.shown])
    columns = labels.columns() | {"file": np.array([path.name for path in files])}
    people = labels.people
    splits = split_names(people, settings.seed)
    flipped = np.mean([flipped_triangles(shape, template.gradients).mean() for shape in shapes])
    writer = DatasetWriter(folder, template)
    together = max(min(SHARD_SIZE, npz_holds(shapes[0].nbytes)), 1)
    for start in range(0, len(files), together):
        rows = slice(start, start + together)
        writer.add_shard({"vertices": shapes[rows]} | {name: column[rows] for name, column in columns.items()})
    manifest = {"count": len(files), "seed": settings.seed, "unit": unit, "expressions": labels.expressions}
    manifest |= {"flipped": float(flipped), "splits": splits}
    writer.finish(manifest, {"attributes": labels.names, "measures": labels.values, "labels": labels.values > 0})
    height = float(np.median(heights)) * UNITS[unit]
    notes = (*_left_out(mesh_folder, files), *_uv_notes(mesh_folder, template), *labels.notes)
    return ImportSummary(len(files), len(people), len(labels.expressions), unit, height, notes)


def _files(folder: Path) -> list[Path]:
    """The meshes of a folder, at least two, whose names are UTF-8 and whose vertices have numbers."""
    files = mesh_files(folder)
    if len(files) < 2:
        nested = _nested(folder)
        beneath = f", and {nested} in sub-folders, which are not entered" if nested else ""
        counts = Counter(path.suffix.lower() for path in folder.iterdir() if is_mesh_file(path))
        given = " and ".join(f"{count} {suffix}" for suffix, count in sorted(counts.items())) or "0"
        expected = "at least two OBJ files, or other meshes of one format and no OBJ"
        raise InputError(f"{shown(folder)}: expected {expected}, found {given}{beneath}")
    if files[0].suffix.lower() == ".stl":
        # Its corners are numbered anew by where they are, so that the numbers of an annotation mean others.
        expected = "OBJ, PLY, GLB or glTF files, which number their vertices as the annotation does"
        raise InputError(f"{shown(folder)}: expected {expected}, found STL")
    for path in files:
        if not is_utf8(path.name):
            raise InputError(f"{shown(path)}: expected a name in UTF-8, found another")
    return files


def _nested(folder: Path) -> int:
    """How many meshes the sub-folders of a folder have that can be looked into."""
    count = 0
    for below in folder.iterdir():
        with suppress(OSError):
            count += sum(map(is_mesh_file, below.iterdir())) if below.is_dir() else 0
    return count


def _left_out(folder: Path, files: Sequence[Path]) -> list[str]:
    """A line each about the meshes of other formats than that of the files, and about those in sub-folders."""
    others = sum(map(is_mesh_file, folder.iterdir())) - len(files)
    nested = _nested(folder)
    took = f"{folder}: took {len(files)} {files[0].suffix.lower()} files, left out"
    left = {"of other formats": others, "in sub-folders": nested}
    return [f"{took} {count} meshes {where}" for where, count in left.items() if count]


def _uv_notes(folder: Path, mesh: Mesh) -> list[str]:
    """A line about UVs beyond their picture, such as those of several tiles."""
    beyond = None if mesh.uvs is None else uvs_beyond(mesh.uvs)
    if beyond is None:
        return []
    return [f"{folder}: UVs {beyond}: texture refuses those beyond 0 to 1, but with --project-uv"]


def _read_meshes(files: Sequence[Path], progress: Callable[[int, int], None]) -> tuple[Mesh, np.ndarray]:
    """The first Mesh of files of one topology, with the UVs of the first that has any, and the vertices (N, V, 3)
    float32 of all, in the files' own unit."""
    first = read_mesh(files[0])
    if len(files) * first.vertices.size * 4 > MAX_DATASET_BYTES:
        most = MAX_DATASET_BYTES // (first.vertices.size * 4)
        where = files[0].parent
        raise InputError(f"{where}: expected at most {most} such meshes, which fit in memory, found {len(files)}")
    shapes = np.empty((len(files), *first.vertices.shape), dtype=np.float32)
    for number, path in enumerate(files):
        mesh = _mesh_like(path, first, files[0].name)
        shapes[number] = mesh.vertices
        if first.uvs is None:
            first = replace(first, uvs=mesh.uvs, uv_polygons=mesh.uv_polygons)
        progress(number + 1, len(files))
    return first, shapes


def _mesh_like(path: Path, first: Mesh, name: str) -> Mesh:
    """The mesh of a file, whose topology must be that of the first one, called name."""
    mesh = read_mesh(path)
    with naming(path):
        if mesh.polygons.shape != first.polygons.shape or len(mesh.vertices) != len(first.vertices):
            expected = f"{len(first.vertices)} vertices, {len(first.polygons)} polygons"
            given = f"{len(mesh.vertices)} and {len(mesh.polygons)}"
            raise InputError(f"expected the topology of {name} ({expected}), found {given}")
        if not np.array_equal(mesh.polygons, first.polygons):
            raise InputError(f"expected the faces of {name}, found others")
    return mesh
