"""Directions of a dataset's labels in the latent space of a model (deformable paper, section 5.3)."""

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.attributes import measure_attributes
from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.label_directions import LabelTable, label_directions, measure_directions
from caricli.methods.train.stages import Report, Stages, silent
from caricli.models.shape_model import ShapeModel
from caricli.structures import Directions

BATCH = 16
"""Meshes that are encoded at once."""

MEASURED = 24
"""Faces that changes are measured on: each is decoded and measured twice for every latent number."""


@dataclass(frozen=True)
class LabelChoice:
    """names: of the labels to train; none for all. count: training meshes, evenly spread; 0 for all. seed: of folds."""

    names: tuple[str, ...] = ()
    count: int = 0
    seed: int = 0


@threadpool_limits.wrap(limits=1)
def train_semantic(
    model: ShapeModel, data: Dataset, choice: LabelChoice, stages: Stages = silent
) -> tuple[Directions, dict[str, str]]:
    """Learn directions of a dataset's labels, and measure them on some of its faces.

    The same bytes come out whatever the number of threads, as sums are made by one.

    model: of the dataset's mesh.
    Returns Directions without recipe, and from the names that were left out to the reason.
    Raises InputError when the dataset has no training meshes, or not the labels that were asked for.
    """
    columns = _columns(data, choice.names)
    rows = spread_rows(data.rows("train"), choice.count or len(data.vertices))
    if not len(rows):
        raise InputError("expected training meshes, found none")
    with stages("encoding") as report:
        latents = _encode(model, data.vertices[rows], report)
    measures = data.measures[rows].astype(float)
    every = LabelTable([*data.attributes], data.labels[rows], data.identity[rows], measures)
    table = every.columns(columns)
    with stages("labels") as report:
        directions, skipped = label_directions(latents, table, choice.seed, report)
    for name in choice.names:
        if name in skipped:
            raise InputError(f"label {name}: {skipped[name]}")
    some = latents[np.linspace(0, len(rows) - 1, min(MEASURED, len(rows))).astype(int)]
    if "thresholds" in data.manifest:
        spreads = dict(zip(table.names, measures[:, columns].std(0), strict=True))
    else:
        spreads = _shown_spreads(data, rows)
    measured = measure_directions(directions, some, model, spreads)
    with stages("people") as report:
        people = _encode(model, data.vertices[_regular_test_rows(data)], report)
    return replace(measured, model_id=model.model_id, people=people), skipped


def _columns(data: Dataset, names: tuple[str, ...]) -> list[int]:
    """Where the named labels stand in a dataset, or all of them."""
    attributes = data.attributes
    if not len(attributes):
        raise InputError("expected labels, found none; they come in with caricli dataset import --labels")
    unknown = [name for name in names if name not in attributes]
    if unknown:
        raise InputError(f"expected one of the labels {', '.join(attributes)}, found {unknown[0]!r}")
    return [attributes.index(name) for name in dict.fromkeys(names)] or list(range(len(attributes)))


def _shown_spreads(data: Dataset, rows: np.ndarray) -> dict[str, float]:
    """Standard deviations of what meshes show by themselves, by name: a user's labels have numbers of their own."""
    if not data.template.annotation.has_extra:
        return {}
    shown = [measure_attributes(vertices, data.template) for vertices in data.vertices[rows].astype(float)]
    return {name: float(np.std([each[name] for each in shown])) for name in shown[0]}


def _regular_test_rows(data: Dataset) -> np.ndarray:
    """(I,) the most regular test mesh of every person."""
    test = np.flatnonzero(data.rows("test"))
    test = test[np.lexsort((data.level[test], ~data.regular[test]))]
    _, first = np.unique(data.identity[test], return_index=True)
    return test[first]


def _encode(model: ShapeModel, shapes: np.ndarray, report: Report) -> np.ndarray:
    """(N, D) whitened latents of shapes (N, V, 3)."""
    latents = np.zeros((len(shapes), len(model.prior.mean)))
    for start in range(0, len(shapes), BATCH):
        batch = shapes[start : start + BATCH].astype(float)
        latents[start : start + BATCH] = model.prior.whiten(model.encode(batch))
        report(start + len(batch), len(shapes))
    return latents
