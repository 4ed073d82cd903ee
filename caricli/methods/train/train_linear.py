"""The models that come from decompositions: trained, and measured as they are written."""

from dataclasses import asdict, dataclass
from typing import Any, cast

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.albedo import random_albedos
from caricli.data.dataset import Dataset
from caricli.data.face_grid import face_grid
from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_shape import ShapeError, evaluate_splits, split_rows
from caricli.methods.evaluate.measure_separation import measure_separation
from caricli.methods.train.stages import Report, unwatched
from caricli.models.bilinear.config import BilinearConfig
from caricli.models.bilinear.model import BilinearModel
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint
from caricli.models.config import TrainingConfig
from caricli.models.kinds import model_class
from caricli.models.morphable.config import MorphableConfig
from caricli.models.morphable.model import MorphableModel, MorphableShapes
from caricli.models.shape_model import ComponentModel, ShapeModel

FEWEST = 3
"""Training meshes: two directions, which is the least that a space of shapes can have."""


@dataclass(frozen=True, eq=False)
class LinearTraining:
    """A trained model and what it is worth.

    checkpoint: tensors and metadata, to be written.
    model: ShapeModel, as it comes out of the checkpoint.
    errors: ShapeError by split.
    agreement: of a morphable model, see ``measure_separation``, by group of test meshes; None of others.
    """

    checkpoint: tuple[dict[str, np.ndarray], dict]
    model: ShapeModel
    errors: dict[str, ShapeError]
    agreement: dict | None

    @property
    def figures(self) -> dict:
        """JSON object: model_id, shape errors, and agreement where there is one."""
        errors = {split: asdict(error) for split, error in self.errors.items()}
        figures = {"model_id": self.model.model_id, "shape_error": errors}
        return figures if self.agreement is None else figures | {"agreement": self.agreement}


@threadpool_limits.wrap(limits=1)
def train_linear(
    kind: str, data: Dataset, config: TrainingConfig, recipe: dict, report: Report = unwatched
) -> LinearTraining:
    """Train a model of components on a dataset's training meshes and measure it on all splits.

    The same bytes come out whatever the number of threads, as sums are made by one.

    kind: of models/kinds.py, bilinear, morphable or one whose class is a ComponentModel. recipe: JSON object, how it is
    trained, for the checkpoint.
    Raises InputError when there are too few meshes, or no full grid of them for a bilinear model; NumericsError when
    all are the same.
    """
    report(0, 2)
    rows = split_rows(data, "train", FEWEST)
    trained = _trained(kind, data, rows, config)
    report(1, 2)
    checkpoint = model_to_checkpoint(trained, recipe)
    model = model_from_checkpoint(*checkpoint, f"the trained {kind} model")
    errors = evaluate_splits(model, data)
    agreement = _agreement(model, data) if kind == "morphable" else None
    report(2, 2)
    return LinearTraining(checkpoint, model, errors, agreement)


def _trained(kind: str, data: Dataset, rows: np.ndarray, config: TrainingConfig) -> ShapeModel:
    """A model of a kind, trained on some of the meshes."""
    if isinstance(config, BilinearConfig):
        return BilinearModel.train(data.template, data.vertices[face_grid(data, rows).rows], config)
    if isinstance(config, MorphableConfig):
        rows = rows if config.exaggerated else _regular_rows(data, rows)
        albedos = random_albedos(data.template, config.seed)
        people = MorphableShapes(data.vertices[rows], data.identity[rows], data.expression[rows], albedos)
        return MorphableModel.train(data.template, people, config)
    return cast(type[ComponentModel], model_class(kind)).train(data.template, data.vertices[rows], config)


def _regular_rows(data: Dataset, rows: np.ndarray) -> np.ndarray:
    """Those of some meshes that are not exaggerated. Raises InputError where there are too few."""
    regular = rows[data.regular[rows]]
    if len(regular) < FEWEST:
        raise InputError(
            f"expected at least {FEWEST} meshes in the dataset's train split that are not exaggerated, found "
            f"{len(regular)}; with --set exaggerated=true the others count, too"
        )
    return regular


def _agreement(model: Any, data: Dataset) -> dict[str, dict]:
    """How well a morphable model tells who from what on test meshes, and on those that are not exaggerated."""
    groups = {"test": data.rows("test")}
    groups["test_regular"] = groups["test"] & data.regular
    return {
        name: measure_separation(model, data.vertices[rows], data.identity[rows], data.expression[rows])
        for name, rows in groups.items()
    }
