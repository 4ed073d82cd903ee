"""Who a face is, and what it does."""

import numpy as np
import scipy.sparse as sp

from caricli.models.principal_components import MIN_SHARE, principal_components

NO_EXPRESSION = 0
"""The number of the expression that is none, where the data show it."""

_ROUNDS = 3  # of the variances, which hardly change after the second
_RATIOS = (1e-4, 1e2)  # of the variances within and between people, at the least and at the most


def separate(
    rows: np.ndarray, people: np.ndarray, expressions: np.ndarray, dimension: int, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Divide faces into the face without its expression and the expression.

    Least squares of ``face = person + expression`` give what an expression does to everyone. What it does to one face
    alone is part of the rest that ``dimension`` components of the faces without it leave: at every number the share by
    which this rest varies more than on neutral faces.

    rows: (N, M). people, expressions: (N,) ints, who and which expression; where nobody shows ``NO_EXPRESSION`` the
    commonest is none.
    Returns (faces (N, M), offsets (N, M), or (0, M) where all show the same), single precision; their sum is the rows.
    """
    _, people = np.unique(people, return_inverse=True)
    numbers, expressions = np.unique(expressions, return_inverse=True)
    rows = rows.astype(np.float32)
    if len(numbers) == 1:
        return rows, rows[:0]
    commonest = int(np.bincount(expressions).argmax())
    none = int(np.flatnonzero(numbers == NO_EXPRESSION)[0]) if NO_EXPRESSION in numbers else commonest
    effect = _effects(rows - rows.mean(0), people, expressions)
    effect -= effect[none]
    faces = rows - effect[expressions]
    mean, basis, _ = principal_components(faces, dimension, seed)
    rest = faces - mean
    rest -= np.linalg.solve(basis @ basis.T, basis @ rest.T).T @ basis
    calm = expressions == none
    usual = rest[calm].var(0)
    moved = rest[~calm].var(0)
    own = rest * np.clip(1 - usual / np.maximum(moved, 1e-20), 0, 1) * ~calm[:, None]
    return faces - own, effect[expressions] + own


def principal_directions(offsets: np.ndarray, dimension: int, seed: int) -> np.ndarray:
    """Principal directions (E, M) of offsets (N, M) from zero, each one standard deviation long."""
    if not offsets.any():
        return offsets[:0]
    # Slow to import, and only training needs it.
    from sklearn.utils.extmath import randomized_svd

    _, sizes, directions = randomized_svd(offsets, min(dimension, *offsets.shape), n_iter=7, random_state=seed)
    kept = sizes**2 > MIN_SHARE * (sizes**2).sum()
    return (sizes[:, None] * directions / np.sqrt(len(offsets)))[kept]


def _effects(rows: np.ndarray, people: np.ndarray, expressions: np.ndarray) -> np.ndarray:
    """Least squares of ``row = person + expression`` with random people. rows: centred. Returns (E, M) float32.

    A person weighs ``n / (n + ratio)`` for n rows, where the ratio is that of the variances within and between people.
    """
    person = _indicators(people)
    expression = _indicators(expressions)
    together = (expression.T @ person).toarray()
    counts = person.sum(0)
    expression_sums = expression.T @ rows
    person_sums = person.T @ rows
    ratio = 1.0
    spare = len(rows) - together.shape[0] - together.shape[1]
    for _ in range(_ROUNDS):
        # The people are eliminated: what is left has as many unknowns as expressions.
        share = together / (counts + ratio)
        system = np.diag(expression.sum(0)) - share @ together.T
        effect = np.linalg.solve(system, expression_sums - share @ person_sums).astype(np.float32)
        if spare <= 0:
            break
        mean = (person_sums - together.T @ effect) / counts[:, None]
        within = ((rows - effect[expressions] - mean[people]) ** 2).sum() / spare
        between = np.average((mean**2).sum(1), weights=counts) - within * len(counts) / len(rows)
        ratio = float(np.clip(within / max(between, 1e-30), *_RATIOS))
    return effect


def _indicators(groups: np.ndarray) -> sp.csr_array:
    """(N, G): one where a row belongs to a group."""
    return sp.csr_array((np.ones(len(groups), np.float32), (np.arange(len(groups)), groups)))
