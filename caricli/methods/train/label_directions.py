"""Directions of binary labels in a latent space: linear support vector machines (Shen et al. 2020, InterFaceGAN)."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.data.attributes import measure_attributes
from caricli.errors import InputError
from caricli.methods.train.stages import Report, unwatched
from caricli.models.shape_model import ShapeModel
from caricli.structures import Directions

COSTS = (1e-3, 1e-2, 1e-1, 1.0)
"""What C is chosen from."""

FOLDS = 5
"""Of the cross-validation."""

FEWEST = 10
"""Meshes with and without a label: two for each fold."""

RIDGE = 1e-2
"""Of the regression, in units of the whitened latents' variance."""

STEP = 0.5
"""Half of the central differences' width, in standard deviations of the latents."""


@dataclass(frozen=True, eq=False)
class LabelTable:
    """What is known of N meshes.

    names: A of labels.
    labels: (N, A) bool, which mesh has which.
    people: (N,) ints, whose face each is.
    measures: (N, A), what the labels are thresholds of, or None.
    """

    names: list[str]
    labels: np.ndarray
    people: np.ndarray
    measures: np.ndarray | None = None

    def columns(self, chosen: list[int]) -> "LabelTable":
        """The table of some of the labels."""
        measures = None if self.measures is None else self.measures[:, chosen]
        return LabelTable([self.names[k] for k in chosen], self.labels[:, chosen], self.people, measures)


def label_directions(
    latents: np.ndarray, table: LabelTable, seed: int = 0, report: Report = unwatched
) -> tuple[Directions, dict[str, str]]:
    """Find for every label the normal of the hyperplane that parts the meshes with it from those without.

    C is the one with the best area under the ROC curve in a stratified cross-validation that keeps the meshes of a
    person together; classes count by the inverse of their size. A label with fewer than ``FEWEST`` meshes on either
    side, with one person alone, or of people who cannot be divided so, is left out.

    latents: (N, D) whitened. seed: of the folds. report: called with the number of finished labels and all.
    Returns Directions without model, recipe and people, gradients and change as a ridge regression has them; and from
    the names that were left out to the reason.
    Raises InputError when no label is left.
    """
    reasons = {name: _reason(table.labels[:, k], table.people, seed) for k, name in enumerate(table.names)}
    skipped = {name: reason for name, reason in reasons.items() if reason}
    trained = table.columns([k for k, name in enumerate(table.names) if name not in skipped])
    if not trained.names:
        none = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        raise InputError(f"expected a label that can be trained, found none: {none}")
    planes = []
    for label in trained.labels.T:
        planes.append(_separate(latents, label, trained.people, seed))
        report(len(planes), len(trained.names))
    normals = np.array([plane.normal for plane in planes])
    gradients = np.zeros_like(normals) if trained.measures is None else _regress(latents, trained.measures)
    directions = Directions(
        names=tuple(str(name) for name in trained.names),
        normals=normals,
        gradients=gradients,
        auc=np.array([plane.auc for plane in planes]),
        positives=trained.labels.sum(0),
        count=len(latents),
        cost=np.array([plane.cost for plane in planes]),
        change=(gradients * normals).sum(1),
        model_id="",
        recipe={},
        people=np.zeros((0, latents.shape[1])),
    )
    return directions, skipped


def measure_directions(
    directions: Directions, latents: np.ndarray, model: ShapeModel, spreads: dict[str, float]
) -> Directions:
    """Measure on meshes what the regression can only estimate: some measures have hardly a straight line in the data.

    Central differences along every axis for the gradients, and over one standard deviation to either side for the
    change along the normals; means over the given faces. Labels that no mesh shows by itself stay as they are.

    latents: (n, D) whitened, of the faces to measure on. spreads: standard deviations of the measures by name.
    """
    template = model.template
    visible = measure_attributes(template.vertices, template) if template.annotation.has_extra else {}
    rows = [k for k, name in enumerate(directions.names) if name in visible and spreads.get(name, 0) > 0]
    if not rows:
        return directions
    names = [directions.names[k] for k in rows]
    scale = np.array([spreads[name] for name in names])

    def slopes(step: np.ndarray) -> np.ndarray:
        ends = []
        for sign in (1, -1):
            shapes = model.decode(model.prior.colour(latents + sign * step))
            measures = [measure_attributes(vertices, template) for vertices in shapes]
            ends.append(np.mean([[measure[name] for name in names] for measure in measures], axis=0))
        return (ends[0] - ends[1]) / (2 * scale)

    gradients = np.array(directions.gradients)
    change = np.array(directions.change)
    gradients[rows] = np.transpose([slopes(STEP * axis) / STEP for axis in np.eye(latents.shape[1])])
    change[rows] = [slopes(directions.normals[k])[row] for row, k in enumerate(rows)]
    return replace(directions, gradients=gradients, change=change)


def _reason(label: np.ndarray, people: np.ndarray, seed: int) -> str | None:
    """Why a label (N,) bool cannot be trained, or None."""
    with_it = int(label.sum())
    without = int((~label).sum())
    if min(with_it, without) == 0:
        return f"all {len(label)} meshes are of one class"
    if min(with_it, without) < FEWEST:
        return f"expected at least {FEWEST} meshes with it and without, found {with_it} and {without}"
    count = _people(label, people)
    if count < 2:
        return f"expected at least 2 people with it and without, found {count}"
    return None if _folds(label, people, seed) else "expected people with it and without on either side, found none"


def _folds(label: np.ndarray, people: np.ndarray, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rows to learn from and to try with, of the cross-validation, where both have meshes with a label and without."""
    from sklearn.model_selection import StratifiedGroupKFold

    folds = StratifiedGroupKFold(min(FOLDS, _people(label, people)), shuffle=True, random_state=seed)
    parts = folds.split(np.zeros((len(label), 1)), label, people)
    return [(a, b) for a, b in parts if len(set(label[a])) == len(set(label[b])) == 2]


def _people(label: np.ndarray, people: np.ndarray) -> int:
    """How many people have meshes with a label, or without, whichever are fewer."""
    return min(len(np.unique(people[label])), len(np.unique(people[~label])))


@dataclass(frozen=True, eq=False)
class _Plane:
    """normal (D,), of length 1; cost, the C; auc, its cross-validated area under the curve."""

    normal: np.ndarray
    cost: float
    auc: float


def _separate(latents: np.ndarray, label: np.ndarray, people: np.ndarray, seed: int) -> _Plane:
    from sklearn.metrics import roc_auc_score
    from sklearn.svm import LinearSVC

    def normal(rows: np.ndarray | slice, cost: float) -> np.ndarray:
        machine = LinearSVC(C=cost, class_weight="balanced", dual=False, random_state=seed)
        return machine.fit(latents[rows], label[rows]).coef_[0]

    parts = _folds(label, people, seed)
    scores = {c: np.mean([roc_auc_score(label[b], latents[b] @ normal(a, c)) for a, b in parts]) for c in COSTS}
    best = max(scores, key=lambda cost: scores[cost])
    whole = normal(slice(None), best)
    return _Plane(whole / np.linalg.norm(whole), best, scores[best])


def _regress(latents: np.ndarray, measures: np.ndarray) -> np.ndarray:
    """(A, D) ridge regression of the standardised measures; 0 for one that does not vary."""
    spread = measures.std(0)
    targets = (measures - measures.mean(0)) / np.where(spread > 0, spread, 1)
    centred = latents - latents.mean(0)
    gram = centred.T @ centred / len(latents) + RIDGE * np.eye(latents.shape[1])
    return np.linalg.solve(gram, centred.T @ targets / len(latents)).T
