from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.data.held_out import held_out, held_out_by_all, held_out_together
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


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_what_a_dataset_holds_out_no_other_of_the_same_people_trains_with(share):
    faces = np.random.default_rng(0).normal(size=(90, 5, 3)).astype(np.float32)
    numbers = [np.arange(60), np.arange(30, 90), np.arange(60)]
    datasets: Any = [SimpleNamespace(rows=lambda split: np.ones(60, bool), vertices=faces[own]) for own in numbers]
    together = held_out_together(datasets, share, 0)
    alone = [held_out(data, share, 0) for data in datasets]
    out = {face for own, parts in zip(numbers, alone, strict=True) for face in _without(own, parts["train"])}
    for own, parts, single in zip(numbers, together, alone, strict=True):
        assert own[parts["train"]].tolist() == [face for face in own[single["train"]].tolist() if face not in out]
        np.testing.assert_array_equal(parts["test"], single["test"])
    left = sum(len(parts["train"]) for parts in together)
    assert bool(out) == (left < sum(len(parts["train"]) for parts in alone))


def _without(numbers, rows):
    return np.delete(numbers, rows).tolist()


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
