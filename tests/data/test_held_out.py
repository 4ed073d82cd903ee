from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.data.held_out import held_out

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
