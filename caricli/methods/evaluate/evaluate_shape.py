"""How well a shape model holds the shapes of a dataset."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from caricli.data.dataset import SPLITS, Dataset
from caricli.data.evenly import evenly
from caricli.errors import InputError
from caricli.methods.train.stages import Report, unwatched
from caricli.models.shape_model import ShapeModel

BATCH = 32
"""Shapes that are encoded at once: more take more memory and no less time."""


@dataclass(frozen=True)
class ShapeError:
    """Mean distance of vertices over a split: millimetres, percent of the head's height, root mean square latent."""

    meshes: int
    millimetres: float
    percent: float
    prior_rms: float


def spread_rows(rows: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the chosen rows, evenly spread. rows: (N,) bool. Returns (n,) ids."""
    ids = np.flatnonzero(rows)
    return ids[np.array(evenly(range(len(ids)), count), int)]


def split_rows(data: Dataset, split: str, least: int, count: int = 0) -> np.ndarray:
    """(n,) ids of a split's meshes, at most ``count`` of them, evenly spread; 0 for all.

    least: how many meshes the split must have. Raises InputError when it has fewer.
    """
    rows = data.rows(split)
    if rows.sum() < least:
        raise InputError(f"expected at least {least} meshes in the dataset's {split} split, found {rows.sum()}")
    return spread_rows(rows, count or len(rows))


def evaluate_splits(
    model: ShapeModel,
    data: Dataset,
    splits: Iterable[str] = SPLITS,
    count: int = 0,
    report: Report = unwatched,
) -> dict[str, ShapeError]:
    """The ShapeError of every split that has meshes, of at most ``count`` of them, evenly spread; 0 for all.

    report: called with the meshes that are measured, and of how many.
    """
    rows = {split: split_rows(data, split, 0, count) for split in splits}
    total = sum(map(len, rows.values()))
    errors = {}
    done = 0
    for split, numbers in rows.items():
        error = evaluate_shape(model, data.vertices[numbers], partial(_report_all, report, done, total))
        done += len(numbers)
        if error is not None:
            errors[split] = error
    return errors


def _report_all(report: Report, before: int, total: int, done: int) -> None:
    report(before + done, total)


def evaluate_shape(
    model: ShapeModel, shapes: np.ndarray, report: Callable[[int], object] = lambda done: None
) -> ShapeError | None:
    """Encode and decode shapes and measure ``mean_v |v - v*|``.

    shapes: (N, V, 3) metres. report: called with how many are measured.
    Returns None for no shapes.
    """
    if not len(shapes):
        return None
    errors = []
    spreads = []
    for start in range(0, len(shapes), BATCH):
        batch = shapes[start : start + BATCH].astype(np.float64)
        latents = model.encode(batch)
        errors.append(np.linalg.norm(model.decode(latents) - batch, axis=-1).mean(-1))
        spreads.append(model.prior.rms(latents))
        report(start + len(batch))
    error = float(np.concatenate(errors).mean())
    rms = float(np.concatenate(spreads).mean())
    return ShapeError(len(shapes), 1000 * error, 100 * error / model.template.height, rms)
