"""The open caricature dataset: random people, expressions and exaggerations of the head."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.appearance import random_appearance
from caricli.data.attributes import binary_labels
from caricli.data.build_settings import EXPONENTS, BuildSettings, OwnSettings
from caricli.data.dataset import split_identities
from caricli.data.expressions import named_expressions
from caricli.data.mesh_source import DatasetRow, MeshSource, Prior
from caricli.data.move_parts import NAMES
from caricli.data.own_source import OwnSource, Usual
from caricli.data.texture_painter import TexturePainter
from caricli.data.worker_pool import worker_pool
from caricli.data.write_dataset import SHARD_SIZE, DatasetWriter
from caricli.errors import InputError
from caricli.io.kept import kept_arrays
from caricli.io.npz import npz_holds, write_npz
from caricli.io.provenance import sha256_file
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.seeds import DatasetSeed
from caricli.template.head import load_head
from caricli.template.template import Template

ALBEDO_FILE = "albedo.npz"

PRIOR_SHAPES = 360
"""Faces that the prior of the exaggeration by parts is trained with, that say what is usual, and"""
PRIOR_DIMENSION = 128
"""dimensions of its latent: as many as faces need that are nobody of the dataset."""


@dataclass(frozen=True, eq=False)
class _Collection:
    """What is known of all meshes when their vertices are written already; each list has N entries."""

    identities: list[int] = field(default_factory=list)
    measures: list[dict[str, float]] = field(default_factory=list)
    flipped: list[float] = field(default_factory=list)

    def add(self, rows: list[DatasetRow]) -> None:
        """Keep what is needed in the end."""
        self.identities.extend(int(row.columns["identity"]) for row in rows)
        self.measures.extend(row.measures for row in rows)
        self.flipped.extend(row.flipped for row in rows)


def build_dataset(
    folder: Path,
    settings: BuildSettings,
    workers: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    albedos: int = 0,
    albedo_size: int = 256,
) -> dict[str, float]:
    """Build a dataset into an empty folder (sketch paper section 4.1, with exaggeration by parts beside curvature).

    The same settings give the same bytes, whatever the number of workers.

    workers: processes; None for one per usable core. progress: called with the number of finished meshes and their
    total. albedos: how many random colours of the head to draw beside the meshes, as pictures of albedo_size texels a
    side.
    Returns the manifest's summary: meshes, flipped triangles. Raises InputError for more albedos than a file can hold.
    """
    if albedos > npz_holds(3 * albedo_size**2):
        raise InputError(f"{albedos} albedos of {albedo_size} texels a side are more than one file can hold")
    template = load_head().template()
    writer = DatasetWriter(folder, template)
    collection = _Collection()
    with worker_pool(workers, _source(settings, template, workers)) as run:
        rows = _counted(_make_rows(run, settings), _mesh_count(settings), progress)
        while shard := list(islice(rows, SHARD_SIZE)):
            writer.add_shard(_columns(shard))
            collection.add(shard)
    manifest, labels = _describe(settings, collection)
    if albedos:
        manifest["albedo"] = _write_albedos(folder, template, albedos, albedo_size, settings.seed)
    writer.finish(manifest, labels)
    return {"meshes": manifest["count"], "flipped": manifest["flipped"]}


def _source(settings: BuildSettings, template: Template, workers: int | None) -> Callable[[], MeshSource]:
    """What makes the meshes, in every worker."""
    by_random = settings.count is not None and settings.levels > 1
    prior = _train_prior(settings, template, workers) if by_random else None
    if isinstance(settings, OwnSettings):
        return partial(OwnSource, settings, prior, _measure_usual(settings, workers) if by_random else None)
    return partial(MeshSource, settings, prior)


def _measure_usual(settings: OwnSettings, workers: int | None) -> Usual:
    """What neutral faces of people who are not in the dataset usually are."""
    with worker_pool(workers, partial(OwnSource, settings)) as run:
        features = np.array(list(run(OwnSource.neutral_features, range(PRIOR_SHAPES))))
    return features.mean(0), features.std(0)


def _train_prior(settings: BuildSettings, template: Template, workers: int | None) -> Prior:
    """The Prior of faces of people who are not in the dataset: half a minute, and kept for the next one."""

    def train() -> dict[str, np.ndarray]:
        with worker_pool(workers, partial(MeshSource, settings)) as run:
            shapes = np.concatenate(list(run(MeshSource.prior_shape, range(PRIOR_SHAPES))))
        model = IntrinsicModel.train(template, shapes, IntrinsicConfig(PRIOR_DIMENSION, settings.seed))
        return {"mean": model.mean, "basis": model.basis, "offset": model.offset}

    given = (template.vertices, template.faces, settings.seed, settings.expressions)
    kept = kept_arrays("prior", given, train)
    return kept["mean"], kept["basis"], kept["offset"]


def _mesh_count(settings: BuildSettings) -> int:
    if settings.count is not None:
        return settings.count
    return settings.identities * settings.expressions * settings.levels


def _make_rows(run: Callable, settings: BuildSettings) -> Iterator[DatasetRow]:
    """All meshes in their order. run: see ``worker_pool``."""
    if settings.count is not None:
        yield from run(_draw, range(settings.count))
        return
    faces = product(range(settings.identities), range(settings.expressions))
    for levels in run(_levels, faces):
        yield from levels


def _draw(source: MeshSource, number: int) -> DatasetRow:
    return source.draw(number)


def _levels(source: MeshSource, face: tuple[int, int]) -> list[DatasetRow]:
    return source.levels(*face)


def _counted(rows: Iterator[DatasetRow], total: int, progress: Callable[[int, int], None]) -> Iterator[DatasetRow]:
    for done, row in enumerate(rows, 1):
        progress(done, total)
        yield row


def _columns(rows: list[DatasetRow]) -> dict[str, np.ndarray]:
    """A shard's columns."""
    integers = ("identity", "expression", "level", "kind")
    return {
        name: np.array([row.columns[name] for row in rows], np.int32 if name in integers else np.float32)
        for name in rows[0].columns
    }


def _describe(settings: BuildSettings, collection: _Collection) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The manifest's own entries, and the arrays of the labels' file."""
    head = load_head()
    identities = np.array(collection.identities)
    splits = _split(settings, identities)
    names = list(collection.measures[0])
    measures = np.array([[row[name] for name in names] for row in collection.measures])
    training = np.isin(identities, splits["train"])
    compared = training if training.any() else np.ones(len(identities), bool)
    labels, thresholds = binary_labels(measures, names, compared)
    manifest = {
        "settings": asdict(settings),
        "count": len(identities),
        "expressions": list(named_expressions(head.action_names))[: settings.expressions],
        "kinds": list(settings.kinds),
        "exponents": list(EXPONENTS[: settings.levels]),
        "part_changes": list(NAMES),
        "changes": list(head.change_names),
        "flipped": float(np.mean(collection.flipped)),
        "thresholds": dict(zip(names, thresholds.tolist(), strict=True)),
        "splits": splits,
    }
    return manifest, {"attributes": np.array(names), "measures": measures.astype(np.float32), "labels": labels}


def _split(settings: BuildSettings, identities: np.ndarray) -> dict[str, list[int]]:
    generator = np.random.default_rng([settings.seed, DatasetSeed.SPLIT])
    splits = split_identities(range(settings.identities), generator)
    if all(np.isin(identities, split).any() for split in splits.values()):
        return splits
    # A small draw can leave a split without anyone; then only those who were drawn are divided.
    return split_identities(np.unique(identities).tolist(), generator)


def _write_albedos(folder: Path, template: Template, count: int, size: int, seed: int) -> dict[str, Any]:
    """Draw the albedos into their file. Returns its entry in the manifest."""
    painter = TexturePainter(template, size)
    pictures = np.empty((count, size, size, 3), np.uint8)
    for number in range(count):
        pictures[number] = painter.draw(random_appearance(np.random.default_rng([seed, DatasetSeed.ALBEDO, number])))
    write_npz(folder / ALBEDO_FILE, {"albedo": pictures})
    digest = sha256_file(folder / ALBEDO_FILE)
    return {"file": ALBEDO_FILE, "count": count, "size": size, "seed": seed, "sha256": digest}
