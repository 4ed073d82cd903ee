"""Singular value decomposition of a table of people and expressions, in each of its modes."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Modes:
    """``table[p, e] = core x_2 people[p] x_3 expressions[e]`` (sketch paper, equation 1), nearly.

    core: (M, I, E'). people: (P, I). expressions: (E, E').
    """

    core: np.ndarray
    people: np.ndarray
    expressions: np.ndarray


def n_mode_svd(table: np.ndarray, identity: int, expression: int) -> Modes:
    """N-mode singular value decomposition, truncated in the modes of people and expressions.

    Nothing is subtracted before: the first direction of each mode is about what all have in common. Directions have the
    sign in which the sum of the people's, or expressions', coefficients is positive.

    table: (P, E, M). identity, expression: how many directions to keep, fewer where there are fewer.
    """
    people = _directions(table, identity)
    expressions = _directions(table.swapaxes(0, 1), expression)
    by_person = np.stack([people.T @ column.astype(float) for column in table.swapaxes(0, 1)], 1)
    return Modes(np.einsum("iem,ek->mik", by_person, expressions, optimize=True), people, expressions)


def _directions(table: np.ndarray, count: int) -> np.ndarray:
    """The first singular vectors (N, count) of a table (N, K, M) in its first mode."""
    products = np.zeros((len(table), len(table)))
    for k in range(table.shape[1]):
        rows = table[:, k].astype(float)
        products += rows @ rows.T
    vectors = np.linalg.eigh(products)[1][:, ::-1][:, :count]
    return vectors * np.where(vectors.sum(0) < 0, -1, 1)
