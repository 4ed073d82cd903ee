"""Faces of people who are trained with that no training sees: a random share of them (sketch paper, section 4.4)."""

import numpy as np

from caricli.data.dataset import Dataset
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
