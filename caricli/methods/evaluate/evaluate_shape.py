"""How well a shape model holds the shapes of a dataset."""

from dataclasses import dataclass

import numpy as np

_BATCH = 32


@dataclass(frozen=True)
class ShapeError:
    """Mean distance of vertices over a split: millimetres, percent of the head's height, root mean square latent."""

    meshes: int
    millimetres: float
    percent: float
    prior_rms: float


def spread_rows(rows, count):
    """At most ``count`` of the chosen rows, evenly spread. rows: (N,) bool. Returns (n,) ids."""
    ids = np.flatnonzero(rows)
    return ids[np.linspace(0, len(ids) - 1, min(count, len(ids))).round().astype(int)] if len(ids) else ids


def evaluate_shape(model, shapes):
    """Encode and decode shapes and measure ``mean_v |v - v*|``.

    model: ShapeModel. shapes: (N, V, 3) metres.
    Returns ShapeError, or None for no shapes.
    """
    if not len(shapes):
        return None
    errors, spreads = [], []
    for start in range(0, len(shapes), _BATCH):
        batch = shapes[start : start + _BATCH].astype(np.float64)
        latents = model.encode(batch)
        errors.append(np.linalg.norm(model.decode(latents) - batch, axis=-1).mean(-1))
        spreads.append(model.prior.rms(latents))
    error = float(np.concatenate(errors).mean())
    rms = float(np.concatenate(spreads).mean())
    return ShapeError(len(shapes), 1000 * error, 100 * error / model.template.height, rms)
