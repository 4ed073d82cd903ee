import numpy as np

from caricli.data.expressions import named_expressions
from caricli.methods.creases.random_acts import random_acts
from caricli.structures.arkit import ARKIT_NAMES


def test_acts_are_expressions_and_blends_of_them():
    named = named_expressions(ARKIT_NAMES)
    acts = random_acts(named, 60, np.random.default_rng(0))
    assert len(acts) == 60 and acts[0] == {}
    weights = np.array([[act.get(name, 0.0) for name in ARKIT_NAMES] for act in acts])
    assert (weights >= 0).all() and weights.max() <= 1 and weights[1:].any(1).all()
    assert {name for act in acts for name in act} <= set(ARKIT_NAMES)
    # Sides differ, but not by much.
    left = weights[:, ARKIT_NAMES.index("browDownLeft")]
    right = weights[:, ARKIT_NAMES.index("browDownRight")]
    assert np.abs(left - right).max() > 0.05 and np.corrcoef(left, right)[0, 1] > 0.8
    assert acts == random_acts(named, 60, np.random.default_rng(0))


def test_either_side_does_more_than_the_other():
    named = {"neutral": {}, "grin": {"mouthSmileLeft": 0.4, "mouthSmileRight": 0.4}}
    acts = random_acts(named, 40, np.random.default_rng(1))[1:]
    left, right = np.array([[act["mouthSmileLeft"], act["mouthSmileRight"]] for act in acts]).T
    assert (left > right).any() and (right > left).any()
    assert np.abs(np.log(left / right)).max() > 0.1
