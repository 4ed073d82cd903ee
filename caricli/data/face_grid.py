"""The people and expressions of a dataset as a full table."""

from dataclasses import dataclass

import numpy as np

from caricli.data.dataset import Dataset
from caricli.errors import InputError


@dataclass(frozen=True, eq=False)
class FaceGrid:
    """Meshes by who and what; an exaggerated person counts as another one (sketch paper, section 4.2).

    rows: (P, E) numbers of the dataset's meshes. people: (P, 2) identity and level of exaggeration. expressions: (E,)
    numbers.
    """

    rows: np.ndarray
    people: np.ndarray
    expressions: np.ndarray


def face_grid(data: Dataset, rows: np.ndarray) -> FaceGrid:
    """The table of some of a dataset's meshes.

    rows: (n,) numbers of meshes. Raises InputError where somebody shows an expression more than once or not at all.
    """
    people, person = np.unique(np.stack([data.identity[rows], data.level[rows]], 1), axis=0, return_inverse=True)
    expressions, expression = np.unique(data.expression[rows], return_inverse=True)
    counts = np.zeros((len(people), len(expressions)), int)
    np.add.at(counts, (person.ravel(), expression), 1)
    if (counts != 1).any():
        persons = len(np.unique(people[:, 0]))
        raise InputError(
            "expected everyone's every expression once at every level, a full grid as `caricli dataset build` makes it "
            f"without --count, found {(counts == 1).sum()} of {counts.size} faces once, of {persons} people at "
            f"{len(people)} levels in all"
        )
    table = np.zeros_like(counts)
    table[person.ravel(), expression] = rows
    return FaceGrid(table, people, expressions)
