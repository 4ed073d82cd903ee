"""Faces to draw sketches of: those of datasets, and mixtures of people with the expression of one face."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.models.linear_model import LinearModel
from caricli.models.morphable.separate import NO_EXPRESSION

_BATCH = 256
"""Faces that are encoded at once."""


@dataclass(frozen=True, eq=False)
class SketchFaces:
    """Latents of faces, divided into who and what.

    latents: (N, D). offsets: (N, D) what the expression adds to the face at rest.
    """

    latents: np.ndarray
    offsets: np.ndarray

    @classmethod
    def of(cls, datasets: Sequence[Dataset], model: LinearModel, split: str = "train") -> Self:
        """The faces of a split.

        Where somebody is there at rest with the same exaggeration, the expression is the difference from that face;
        else it is what it is of others on average.

        model: LinearModel of the datasets' topology. Raises InputError where there are no faces.
        """
        latents = []
        who = []
        expressions = []
        for number, data in enumerate(datasets):
            rows = np.flatnonzero(data.rows(split))
            latents += [model.encode(data.vertices[part].astype(float)) for part in _parts(rows)]
            kinds = data.factors.get("kind", np.zeros(len(data.level), int))[rows]
            parts = kinds >= 2  # who is exaggerated by parts is there once
            alone = np.where(parts, 1 + np.arange(len(rows)), 0)
            column = np.full(len(rows), number)
            who.append(np.stack([column, data.identity[rows], data.level[rows], alone], 1))
            expressions.append(data.expression[rows])
        if not latents:
            raise InputError(f"expected a dataset with faces of the {split} split, found none")
        own = np.concatenate(latents)
        return cls(own, _offsets(own, np.concatenate(who), np.concatenate(expressions)))

    def draw(self, count: int, generator: np.random.Generator, mixed: float, people: int) -> np.ndarray:
        """Latents (count, D) of random faces.

        mixed: share of those that are of nobody: up to ``people`` faces at rest are mixed at random, and moved away
        from the mean by as much as mixing brought them nearer, or less; then another's expression is added.
        """
        rows = generator.integers(len(self.latents), size=count)
        rest = self.latents - self.offsets
        chosen = generator.integers(len(rest), size=(count, people))
        shares = generator.exponential(size=chosen.shape) * (
            np.arange(people) < generator.integers(1, people + 1, (count, 1))
        )
        shares /= shares.sum(1, keepdims=True)
        mean = rest.mean(0)
        nearer = 1 / np.linalg.norm(shares, axis=1)
        away = 1 + generator.random(count) * (nearer - 1)
        mixture = mean + away[:, None] * (np.einsum("np,npd->nd", shares, rest[chosen]) - mean)
        of_nobody = generator.random(count) < mixed
        return np.where(of_nobody[:, None], mixture + self.offsets[rows], self.latents[rows])


def _parts(rows: np.ndarray) -> list[np.ndarray]:
    return [rows[start : start + _BATCH] for start in range(0, len(rows), _BATCH)]


def _offsets(latents: np.ndarray, who: np.ndarray, expressions: np.ndarray) -> np.ndarray:
    """What expressions add, (N, D). who: (N, C), equal rows are of one person with one exaggeration."""
    _, person = np.unique(who, axis=0, return_inverse=True)
    person = person.ravel()
    at_rest = np.full(person.max() + 1, -1)
    resting = np.flatnonzero(expressions == NO_EXPRESSION)
    at_rest[person[resting]] = resting
    partner = at_rest[person]
    has = partner >= 0
    offsets = np.where(has[:, None], latents - latents[partner], 0)
    for expression in np.unique(expressions):
        shown = expressions == expression
        if (shown & has).any() and expression != NO_EXPRESSION:
            offsets[shown & ~has] = offsets[shown & has].mean(0)
    return offsets
