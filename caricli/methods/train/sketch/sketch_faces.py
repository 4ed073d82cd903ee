"""Faces to draw sketches of: those of datasets, and mixtures of people with the expression of one face."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.held_out import held_out_together
from caricli.errors import InputError
from caricli.models.linear_model import LinearModel
from caricli.models.morphable.separate import NO_EXPRESSION

_BATCH = 256
"""Faces that are encoded at once."""


@dataclass(frozen=True, eq=False)
class SketchFaces:
    """Latents of faces, divided into who and what.

    latents: (N, D). offsets: (N, D) what the expression adds to the face at rest. group: (N,) numbers from 0, equal for
    faces that are exaggerated alike. rests: for every group (P, D), the faces at rest of everybody in it. likely: (N,)
    ascending to 1, the chance of a face or one before it: of a group all expressions are equally likely, whatever faces
    of people there are who show but one.
    """

    latents: np.ndarray
    offsets: np.ndarray
    group: np.ndarray
    rests: tuple[np.ndarray, ...]
    likely: np.ndarray

    @classmethod
    def of(cls, datasets: Sequence[Dataset], model: LinearModel, held: float = 0.0, seed: int = 0) -> Self:
        """The faces of the training split, but for those that are held out of any dataset.

        Where somebody is there at rest with the same exaggeration, the expression is the difference from that face;
        else it is what it is of others on average.

        model: LinearModel of the datasets' topology. held, seed: see ``held_out_together``.
        Raises InputError where there are no faces.
        """
        latents = []
        who = []
        expressions = []
        together = held_out_together(datasets, held, seed)
        for number, (data, own) in enumerate(zip(datasets, together, strict=True)):
            rows = own["train"]
            latents += [model.encode(data.vertices[part].astype(float)) for part in batches(rows)]
            kinds = data.factors.get("kind", np.zeros(len(data.level), int))[rows]
            parts = kinds >= 2  # who is exaggerated by parts is there once
            alone = np.where(parts, 1 + np.arange(len(rows)), 0)
            column = np.full(len(rows), number)
            who.append(np.stack([column, data.identity[rows], data.level[rows], alone, kinds * parts], 1))
            expressions.append(data.expression[rows])
        if not latents:
            raise InputError("expected a dataset with faces of the train split, found none")
        return cls.divided(np.concatenate(latents), np.concatenate(who), np.concatenate(expressions))

    @classmethod
    def divided(cls, latents: np.ndarray, who: np.ndarray, expressions: np.ndarray) -> Self:
        """Latents (N, D) of people (N, 5): dataset, number, level, a number where one is there but once, and kind."""
        _, first, person = np.unique(who[:, :4], axis=0, return_index=True, return_inverse=True)
        person = person.ravel()
        offsets = _offsets(latents, person, expressions)
        group = np.unique(who[:, [2, 4]], axis=0, return_inverse=True)[1].ravel()
        rest = (latents - offsets)[first]
        rests = tuple(rest[group[first] == number] for number in range(group.max() + 1))
        return cls(latents, offsets, group, rests, _even(group, expressions))

    def draw(self, count: int, generator: np.random.Generator, mixed: float, people: int) -> np.ndarray:
        """Latents (count, D) of random faces.

        mixed: share of those that are of nobody: up to ``people`` faces at rest that are exaggerated alike are mixed at
        random, and moved away from their mean by as much as mixing brought them nearer; then the expression of one with
        that exaggeration is added.
        """
        rows = np.searchsorted(self.likely, generator.random(count), side="right").clip(max=len(self.latents) - 1)
        chosen = generator.random((count, people))
        shares = generator.exponential(size=chosen.shape) * (
            np.arange(people) < generator.integers(1, people + 1, (count, 1))
        )
        shares /= shares.sum(1, keepdims=True)
        away = 1 / np.linalg.norm(shares, axis=1)
        of_nobody = generator.random(count) < mixed
        faces = self.latents[rows]
        for number, rest in enumerate(self.rests):
            own = of_nobody & (self.group[rows] == number)
            mixture = np.einsum("np,npd->nd", shares[own], rest[(chosen[own] * len(rest)).astype(int)])
            mean = rest.mean(0)
            faces[own] = mean + away[own, None] * (mixture - mean) + self.offsets[rows[own]]
        return faces


def batches(rows: np.ndarray) -> list[np.ndarray]:
    """Rows one after the other, as many at once as are encoded."""
    return [rows[start : start + _BATCH] for start in range(0, len(rows), _BATCH)]


def _even(group: np.ndarray, expressions: np.ndarray) -> np.ndarray:
    """See SketchFaces.likely."""
    both, alike, counts = np.unique(np.stack([group, expressions]), axis=1, return_inverse=True, return_counts=True)
    chances = np.bincount(group)[group] / np.bincount(both[0])[group] / counts[alike.ravel()]
    return np.cumsum(chances) / chances.sum()


def _offsets(latents: np.ndarray, person: np.ndarray, expressions: np.ndarray) -> np.ndarray:
    """What expressions add, (N, D). person: (N,), equal numbers are of one person with one exaggeration."""
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
