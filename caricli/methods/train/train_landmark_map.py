"""A map between the landmarks of normal faces and of caricatures, trained without pairs."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import Dataset
from caricli.errors import InputError, NumericsError
from caricli.methods.evaluate.evaluate_landmark_map import evaluate_landmark_map
from caricli.methods.train.see_faces import map_faces
from caricli.methods.train.stages import Stages, silent
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.landmark_map.model import LandmarkMap, map_from_checkpoint, map_to_checkpoint

FEWEST = 3
"""Meshes of a domain, below which there is no variance to speak of."""

LEAST = 1e-3
"""Variance of a style, of that of the largest, and of that one, of how much normal faces differ: less is chance."""


@dataclass(frozen=True, eq=False)
class MapTraining:
    """A trained map.

    checkpoint: tensors and metadata, to be written.
    recipe: JSON object, how it was trained and whom with.
    landmark_map: LandmarkMap, as it comes out of the checkpoint.
    figures: JSON object, see ``evaluate_landmark_map``.
    """

    checkpoint: tuple[dict[str, np.ndarray], dict]
    recipe: dict
    landmark_map: LandmarkMap
    figures: dict


@threadpool_limits.wrap(limits=1)
def train_landmark_map(
    data: Dataset, config: LandmarkMapConfig, seed: int, recipe: dict, stages: Stages = silent
) -> MapTraining:
    """Train a map on the faces of a dataset and measure it on people held out, and on those of the test split.

    The same bytes come out whatever the number of threads, as sums are made by one.

    seed: of all draws. recipe: JSON object, how it is trained; people are added, see ``MapFaces.seen_people``.
    Raises InputError when a domain has too few meshes, NumericsError as ``learn_landmark_map``.
    """
    with stages("looking at faces") as report:
        faces = map_faces(data, config.views, seed, report)
    for name, own in faces.rows["training"].items():
        if len(own) < FEWEST:
            raise InputError(f"expected at least {FEWEST} training meshes of {name} faces, found {len(own)}")
    recipe = recipe | faces.seen_people().as_recipe()
    checkpoint = map_to_checkpoint(learn_landmark_map(faces.seen["training"], config), recipe)
    landmark_map = map_from_checkpoint(*checkpoint, "the trained map")
    with stages("measuring") as report:
        figures = evaluate_landmark_map(landmark_map, faces, report)
    return MapTraining(checkpoint, recipe, landmark_map, figures)


def learn_landmark_map(training: dict[str, np.ndarray], config: LandmarkMapConfig) -> LandmarkMap:
    """Learn a LandmarkMap without pairs, labels or poses, in closed form.

    It takes the place of the networks of the expressions paper (section 3.2.1). What caricatures add to normal faces
    has the covariance by which the two domains differ, without its negative part; heads turn and act in both, which
    leaves them out of it. ``to_normal`` is Wiener's filter that takes the addition off again.

    training: aligned landmarks (N, 68, 2) by domain, in any order.
    Raises NumericsError where all faces of a domain are the same, or caricatures differ no more than normal faces.
    """
    rows = {name: points.reshape(len(points), -1) for name, points in training.items()}
    spreads = {name: np.cov(own.T) for name, own in rows.items()}
    if not all(np.trace(spread) > 1e-12 for spread in spreads.values()):
        raise NumericsError("expected faces that differ in both domains, found the same")
    values, vectors = np.linalg.eigh(spreads["caricature"] - spreads["normal"])
    if values[-1] <= LEAST * np.trace(spreads["normal"]):
        raise NumericsError("expected caricatures that differ more than normal faces do, found none")
    parts = vectors * np.sqrt(np.maximum(values, 0))
    total = spreads["normal"] + parts @ parts.T + config.noise**2 * np.eye(len(values))
    largest = parts.T[::-1][: config.styles]
    kept = values[::-1][: config.styles] > LEAST * values[-1]
    to_normal = np.linalg.solve(total, spreads["normal"])
    return LandmarkMap(rows["normal"].mean(0), rows["caricature"].mean(0), to_normal, largest[kept])
