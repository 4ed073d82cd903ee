import numpy as np
import pytest

from caricli.data.albedo import vertex_painter
from caricli.methods.creases.crease_pattern import random_pattern
from caricli.methods.creases.relief import ReliefMaker
from caricli.template.head import load_head


@pytest.fixture(scope="module")
def marks():
    return vertex_painter(load_head().template()).marks[:68, :2]


def folded(marks, age, weights, seed=1):
    return ReliefMaker(random_pattern(marks, age, np.random.default_rng(seed))).relief(weights)


def test_the_same_seed_gives_the_same_folds(marks):
    first, second = (folded(marks, 0.8, {"browInnerUp": 1.0}) for _ in range(2))
    np.testing.assert_array_equal(first.slopes, second.slopes)
    assert np.abs(first.slopes - folded(marks, 0.8, {"browInnerUp": 1.0}, seed=2).slopes).max() > 0.1


@pytest.mark.parametrize(
    "action, place",
    [
        ("browInnerUp", (0.0, 0.5)),
        ("browDownLeft", (0.06, 0.2)),
        ("eyeSquintRight", (-0.62, 0.0)),
        ("mouthSmileLeft", (0.4, -0.7)),
        ("mouthPucker", (0.0, -0.62)),
        ("mouthShrugLower", (0.0, -1.0)),
        ("noseSneerRight", (-0.08, -0.15)),
    ],
)
def test_an_action_folds_the_skin_where_it_acts(marks, action, place):
    rest = folded(marks, 0.9, {})
    change = np.abs(folded(marks, 0.9, {action: 1.0}).stain - rest.stain)
    rows, columns = np.nonzero(change > 0.5 * change.max())
    away = np.hypot(columns * 0.006 - 0.95 - place[0], rows * 0.006 - 1.5 - place[1])
    assert change.max() > 0.1 and away.min() < 0.12


def test_old_skin_folds_deeper_and_keeps_folds_at_rest(marks):
    for weights in ({}, {"browInnerUp": 1.0}):
        young, old = (np.mean([folded(marks, age, weights, k).stain.sum() for k in range(3)]) for age in (0.0, 1.0))
        assert old > 1.2 * young
    assert not folded(marks, 0.0, {}).stain.any()


def test_one_side_alone_folds_with_one_brow(marks):
    stain = folded(marks, 0.9, {"browOuterUpLeft": 1.0}).stain - folded(marks, 0.9, {}).stain
    middle = stain.shape[1] // 2
    assert stain[:, middle:].sum() > 3 * stain[:, :middle].sum()
