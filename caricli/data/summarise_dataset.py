"""A dataset in a few lines."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import eigvalsh

from caricli.data.dataset import SPLITS, Dataset
from caricli.geometry.repair.flipped_triangles import flipped_triangles

_BATCH = 32
"""Meshes whose triangles are compared at once."""

_MOST_SHAPES = 4000
"""Shapes whose components are counted: their Gram matrix takes 128 MB."""

_SHARE = 0.99
"""Of the variance that components are to explain."""


def components_for(shapes: np.ndarray) -> int:
    """How many principal components explain 99 % of the variance of shapes (N, V, 3), at most 4,000 of them."""
    shapes = shapes[:: -(-len(shapes) // _MOST_SHAPES)]
    rows = shapes.reshape(len(shapes), -1).astype(np.float64)
    rows -= rows.mean(0)
    # The smaller of the two Gram matrices has the same spectrum.
    gram = rows @ rows.T if len(rows) < rows.shape[1] else rows.T @ rows
    spectrum = np.maximum(eigvalsh(gram)[::-1], 0)
    return int((np.cumsum(spectrum) < _SHARE * spectrum.sum()).sum()) + 1


def summarise_dataset(data: Dataset) -> Iterator[str]:
    """Lines for people: meshes, people, splits, kinds, flipped triangles, components, labels."""
    count = len(data.vertices)
    people = len(np.unique(data.identity))
    yield f"meshes {count}, people {people}, vertices {len(data.template.vertices)}, faces {len(data.template.faces)}"
    sizes = ", ".join(f"{split} {int(data.rows(split).sum())}" for split in SPLITS)
    yield f"split by identity: {sizes}"
    if "kind" in data.factors:
        numbers = np.bincount(data.factors["kind"], minlength=len(data.manifest["kinds"]))
        yield "kinds: " + ", ".join(f"{k} {n}" for k, n in zip(data.manifest["kinds"], numbers, strict=True))
    flipped = _flipped_shares(data)
    yield f"flipped triangles: mean {100 * flipped.mean():.3f} %, worst mesh {100 * flipped.max():.3f} %"
    yield f"components for 99 % of the variance: {components_for(data.vertices)}"
    if len(data.attributes):
        shares = zip(data.attributes, data.labels.mean(0), strict=True)
        yield "labels: " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares)


def _flipped_shares(data: Dataset) -> np.ndarray:
    """(N,) share of the triangles of every mesh."""
    gradients = data.template.gradients
    batches = (data.vertices[k : k + _BATCH] for k in range(0, len(data.vertices), _BATCH))
    return np.concatenate([flipped_triangles(batch, gradients).mean(-1) for batch in batches])
