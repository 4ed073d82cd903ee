"""Faces of people who are trained with that no training sees: a random share of them (sketch paper, section 4.4)."""

import hashlib
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.seeds import TrainingSeed

VALIDATED = 5
"""One of so many held-out faces is to validate with, the others to test with."""


def held_out(data: Dataset, share: float, seed: int) -> dict[str, np.ndarray]:
    """Row numbers of the training split, ascending, by "train", "validation" and "test".

    share: of the split's faces that are not trained with, 0 to 1. seed: of their choice.
    """
    rows = np.flatnonzero(data.rows("train"))
    generator = np.random.default_rng([seed, TrainingSeed.HELD, len(rows)])
    shuffled = generator.permutation(rows)
    held = shuffled[: round(share * len(rows))]
    parts = {
        "train": shuffled[len(held) :],
        "validation": held[::VALIDATED],
        "test": np.delete(held, slice(None, None, VALIDATED)),
    }
    return {name: np.sort(part) for name, part in parts.items()}


def held_out_together(datasets: Sequence[Dataset], share: float, seed: int) -> list[dict[str, np.ndarray]]:
    """``held_out`` of every dataset, without training faces that another dataset of the same people holds out."""
    parts = [held_out(data, share, seed) for data in datasets]
    if not share or len(datasets) == 1:
        return parts
    out: set[bytes] = set()
    for data, own in zip(datasets, parts, strict=True):
        out.update(_digests(data, own["validation"]), _digests(data, own["test"]))
    return [
        own | {"train": own["train"][[digest not in out for digest in _digests(data, own["train"])]]}
        for data, own in zip(datasets, parts, strict=True)
    ]


def held_out_by_all(data: Dataset, choices: Collection[tuple[float, int] | None], count: int) -> dict[str, np.ndarray]:
    """Row numbers of the faces that several trainings held out alike, ascending, by "validation" and "test".

    choices: distinct ones of the trainings, each the share and seed of ``held_out``, or None where nothing is said.
    count: of faces to test with, at most, evenly spread.
    Raises InputError where there are several choices, or no face was held out to test with.
    """
    choice = next(iter(choices)) if len(choices) == 1 else None
    if choice is None or not choice[0]:
        several = ", ".join(sorted(_told(each) for each in choices))
        raise InputError(f"expected trainings that held the same faces out, found {several}")
    parts = held_out(data, *choice)
    tested = parts["test"]
    if not len(tested):
        raise InputError("expected faces that the trainings held out, found none")
    return {"validation": parts["validation"], "test": tested[:: -(-len(tested) // count)]}


def _digests(data: Dataset, rows: np.ndarray) -> Iterator[bytes]:
    """What tells the faces of rows: one that two datasets have is of the same vertices in both."""
    return (hashlib.sha256(data.vertices[row].tobytes()).digest() for row in rows)


def _told(choice: tuple[float, int] | None) -> str:
    return "none held out" if choice is None or not choice[0] else f"a share of {choice[0]:g} by seed {choice[1]}"
