"""Directions of binary labels in a latent space: linear support vector machines (Shen et al. 2020, InterFaceGAN)."""

from dataclasses import replace

import numpy as np

from caricli.data.attributes import measure_attributes
from caricli.errors import InputError
from caricli.structures import Directions

COSTS = (1e-3, 1e-2, 1e-1, 1.0)
FOLDS, FEWEST = 5, 10
_RIDGE, _STEP = 1e-2, 0.5


def train_semantic(latents, labels, names, groups, measures=None, seed=0, report=lambda done, total: None):
    """Find for every label the normal of the hyperplane that parts the meshes with it from those without.

    C is the one with the best area under the ROC curve in a stratified cross-validation that keeps the meshes of a
    person together; classes count by the inverse of their size. A label with fewer than ``FEWEST`` meshes on either
    side, or with one person alone, is left out.

    latents: (N, D) whitened. labels: (N, A) bool. names: A texts. groups: (N,) identities. measures: (N, A), what the
    labels are thresholds of, or None. seed: of the folds. report: called with the number of finished labels and all.
    Returns Directions without model, recipe and people, gradients and change as a ridge regression has them; and a dict
    from the names that were left out to the reason.
    Raises InputError when no label is left.
    """
    reasons = {name: _reason(labels[:, k], groups) for k, name in enumerate(names)}
    skipped = {name: reason for name, reason in reasons.items() if reason}
    kept = [k for k, name in enumerate(names) if name not in skipped]
    if not kept:
        raise InputError("no label can be trained: " + "; ".join(f"{n}: {r}" for n, r in skipped.items()))
    normals, auc, cost = [], [], []
    for done, k in enumerate(kept):
        normal, best_cost, best_auc = _separate(latents, labels[:, k], groups, seed)
        normals.append(normal)
        auc.append(best_auc)
        cost.append(best_cost)
        report(done + 1, len(kept))
    normals = np.array(normals)
    gradients = np.zeros_like(normals) if measures is None else _regress(latents, measures[:, kept])
    return Directions(
        names=tuple(str(names[k]) for k in kept),
        normals=normals,
        gradients=gradients,
        auc=np.array(auc),
        positives=labels[:, kept].sum(0),
        count=len(latents),
        cost=np.array(cost),
        change=(gradients * normals).sum(1),
        model_id="",
        recipe={},
        people=np.zeros((0, latents.shape[1])),
    ), skipped


def measure_directions(directions, latents, model, spreads):
    """Measure on meshes what the regression can only estimate: some measures have hardly a straight line in the data.

    Central differences along every axis for the gradients, and over one standard deviation to either side for the
    change along the normals; means over the given faces. Labels that no mesh shows by itself stay as they are.

    directions: Directions. latents: (n, D) whitened, of the faces to measure on. model: ShapeModel. spreads: dict from
    names to the standard deviations of the measures.
    Returns Directions.
    """
    template = model.template
    shown = measure_attributes(template.vertices, template) if template.annotation.has_extra else {}
    known = [k for k, name in enumerate(directions.names) if name in shown and spreads.get(name, 0) > 0]
    if not known:
        return directions
    names = [directions.names[k] for k in known]
    scale = np.array([spreads[name] for name in names])

    def slopes(step):
        ends = []
        for sign in (1, -1):
            rows = [measure_attributes(v, template) for v in model.decode(model.prior.colour(latents + sign * step))]
            ends.append(np.mean([[row[name] for name in names] for row in rows], axis=0))
        return (ends[0] - ends[1]) / (2 * scale)

    gradients, change = np.array(directions.gradients), np.array(directions.change)
    gradients[known] = np.transpose([slopes(_STEP * axis) / _STEP for axis in np.eye(latents.shape[1])])
    change[known] = [slopes(directions.normals[k])[row] for row, k in enumerate(known)]
    return replace(directions, gradients=gradients, change=change)


def _reason(label, groups):
    """Why a label cannot be trained, or None."""
    counts = int(label.sum()), int((~label).sum())
    people = min(len(np.unique(groups[label])), len(np.unique(groups[~label])))
    if min(counts) == 0:
        return f"all {len(label)} meshes are of one class"
    if min(counts) < FEWEST:
        return f"expected at least {FEWEST} meshes with it and without, found {counts[0]} and {counts[1]}"
    return f"expected at least 2 people with it and without, found {people}" if people < 2 else None


def _separate(latents, label, groups, seed):
    """(D,) unit normal, C and its cross-validated area under the curve."""
    from sklearn.metrics import roc_auc_score
    from sklearn.model_selection import StratifiedGroupKFold
    from sklearn.svm import LinearSVC

    def normal(rows, cost):
        machine = LinearSVC(C=cost, class_weight="balanced", dual=False, random_state=seed)
        return machine.fit(latents[rows], label[rows]).coef_[0]

    people = min(len(np.unique(groups[label])), len(np.unique(groups[~label])))
    folds = StratifiedGroupKFold(min(FOLDS, people), shuffle=True, random_state=seed)
    parts = [(a, b) for a, b in folds.split(latents, label, groups) if len(set(label[a])) == len(set(label[b])) == 2]
    scores = {c: np.mean([roc_auc_score(label[b], latents[b] @ normal(a, c)) for a, b in parts]) for c in COSTS}
    best = max(scores, key=scores.get)
    found = normal(slice(None), best)
    return found / np.linalg.norm(found), best, scores[best]


def _regress(latents, measures):
    """(A, D) ridge regression of the standardised measures; 0 for one that does not vary."""
    spread = measures.std(0)
    targets = (measures - measures.mean(0)) / np.where(spread > 0, spread, 1)
    centred = latents - latents.mean(0)
    gram = centred.T @ centred / len(latents) + _RIDGE * np.eye(latents.shape[1])
    return np.linalg.solve(gram, centred.T @ targets / len(latents)).T
