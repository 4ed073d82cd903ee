"""Directions of semantic labels in the latent space of a model."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import shown
from caricli.structures.checks import number_problem, refuse
from caricli.structures.seen_people import SeenPeople

_UNIT = 1e-3
_NUMBERS = ("normals", "gradients", "auc", "positives", "cost", "change", "people")


@dataclass(frozen=True, eq=False)
class Directions:
    """Where labels lie in the whitened latents (mean 0, standard deviation 1) of a model.

    names: (A,), distinct.
    normals: (A, D) unit vectors towards the meshes with the label.
    gradients: (A, D) change of the label's measure, in its standard deviations, by the whitened latent; 0 where there
    is no measure.
    auc: (A,) area under the ROC curve, cross-validated, from 0 to 1.
    positives: (A,) meshes with the label, among ``count``.
    cost: (A,) the C of the support vector machines.
    change: (A,) of the measure, in its standard deviations, along one standard deviation of the normal; 0 where there
    is no measure.
    model_id: SHA-256 of the model; "" before it is known.
    recipe: JSON object, how they were trained.
    people: (I, D) whitened latents of the most regular face of everybody among the test meshes, to tell whether an
    edited face is still nearest to its own.
    Raises InputError when the parts do not fit each other or are out of range.
    """

    names: tuple[str, ...]
    normals: np.ndarray
    gradients: np.ndarray
    auc: np.ndarray
    positives: np.ndarray
    count: int
    cost: np.ndarray
    change: np.ndarray
    model_id: str
    recipe: dict
    people: np.ndarray

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        names = self.names
        if not len(names) or not all(names) or len(set(names)) < len(names):
            refuse(f"names: expected a list of distinct names, found {shown(names, 60)}")
        if np.ndim(self.normals) != 2 or 0 in np.shape(self.normals):
            refuse(f"normals: expected (A,D), found {np.shape(self.normals)}")
        count, dimension = np.shape(self.normals)
        shapes: dict[str, tuple] = dict.fromkeys(("names", "auc", "positives", "cost", "change"), (count,))
        shapes["gradients"] = (count, dimension)
        shapes["people"] = (len(self.people) if np.ndim(self.people) else 0, dimension)
        for key, shape in shapes.items():
            if np.shape(getattr(self, key)) != shape:
                refuse(f"{key}: expected the shape {shape}, found {np.shape(getattr(self, key))}")
        for key in _NUMBERS:
            refuse(number_problem(key, np.asarray(getattr(self, key))))
        self._check_ranges()

    @property
    def seen(self) -> SeenPeople | None:
        """Whom they were trained with; None where the recipe does not say. Raises InputError."""
        return SeenPeople.of_recipe(self.recipe)

    @property
    def figures(self) -> dict[str, dict[str, float]]:
        """By name what was measured of a label: auc, positives, cost and change."""
        columns = {key: np.asarray(getattr(self, key)).tolist() for key in ("auc", "positives", "cost", "change")}
        return {name: {key: columns[key][k] for key in columns} for k, name in enumerate(self.names)}

    def _check_ranges(self) -> None:
        lengths = np.linalg.norm(np.asarray(self.normals, float), axis=1)
        if np.abs(lengths - 1).max() > _UNIT:
            refuse(f"normals: expected unit vectors, found lengths from {lengths.min():.3g} to {lengths.max():.3g}")
        if np.min(self.auc) < 0 or np.max(self.auc) > 1:
            refuse("auc: expected numbers from 0 to 1, found others")
        if np.min(self.positives) < 0 or np.max(self.positives) > self.count:
            refuse(f"positives: expected numbers from 0 to {self.count}, found others")
