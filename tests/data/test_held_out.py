from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.data.held_out import held_out, held_out_by_all
from caricli.errors import InputError

IDENTITY = np.repeat(np.arange(10), 20)
DATA: Any = SimpleNamespace(rows=lambda split: IDENTITY < 8)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5])
def test_a_share_of_the_training_faces_is_left_out(share):
    parts = held_out(DATA, share, 0)
    together = np.concatenate(list(parts.values()))
    np.testing.assert_array_equal(np.sort(together), np.arange(160))
    assert len(parts["train"]) == 160 - round(160 * share)
    assert len(parts["validation"]) == -(-round(160 * share) // 5)


def test_the_seed_decides_which():
    parts = [held_out(DATA, 0.1, seed)["test"] for seed in (0, 0, 1)]
    np.testing.assert_array_equal(parts[0], parts[1])
    assert set(parts[0]) != set(parts[2])


def test_what_all_trainings_held_out_is_tested_with_evenly():
    parts = held_out(DATA, 0.2, 3)
    chosen = held_out_by_all(DATA, {(0.2, 3)}, 10)
    np.testing.assert_array_equal(chosen["validation"], parts["validation"])
    np.testing.assert_array_equal(chosen["test"], parts["test"][::3])
    assert len(held_out_by_all(DATA, {(0.2, 3)}, 1000)["test"]) == len(parts["test"])


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        ({(0.2, 3), (0.2, 4)}, "the same faces out, found a share of 0.2 by seed 3, a share of 0.2 by seed 4"),
        ({(0.2, 3), None}, "found a share of 0.2 by seed 3, none held out"),
        ({None}, "found none held out"),
        ({(0.0, 3)}, "found none held out"),
        ({(0.001, 3)}, "expected faces that the trainings held out, found none"),
    ],
)
def test_trainings_that_held_different_faces_out_are_refused(choices, words):
    with pytest.raises(InputError, match=words):
        held_out_by_all(DATA, choices, 10)
