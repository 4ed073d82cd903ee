"""Which expressions a person shows, at random."""

from collections.abc import Mapping

import numpy as np

from caricli.data.expressions import expand_sides
from caricli.structures.arkit import ARKIT_NAMES

_LOUD = (0.45, 1.1)
_BLENDED = 0.4
_UNEVEN = 0.25
"""How strong expressions are of their full weight, least and most, chance that two are blended, and how much one side
differs."""

_ADDED = 0.25
_MORE = (
    *("mouthRollUpper", "mouthRollLower", "mouthShrugLower", "mouthShrugUpper", "mouthPress", "mouthDimple"),
    *("mouthStretch", "mouthFunnel", "noseSneer", "cheekSquint", "eyeBlink", "browInnerUp", "browOuterUp"),
)
"""Chance that one of these actions is added, of both sides, of which expressions hardly have some."""


def random_acts(
    named: Mapping[str, Mapping[str, float]], count: int, generator: np.random.Generator
) -> list[dict[str, float]]:
    """Draw expressions, the neutral one first.

    named: actions with weights by names, the neutral one first. count: how many. Returns weights of actions, 0 to 1.
    """
    others = [weights for weights in named.values() if weights]
    acts: list[dict[str, float]] = [{}]
    order: list[int] = []
    while len(acts) < count:
        order = order or generator.permutation(len(others)).tolist()
        act = _times(others[order.pop()], float(generator.uniform(*_LOUD)))
        if generator.random() < _BLENDED:
            # Half of each, or nobody could tell what it is.
            share = float(generator.uniform(0.3, 0.7))
            second = _times(others[int(generator.integers(len(others)))], float(generator.uniform(*_LOUD)))
            act = {
                name: (1 - share) * act.get(name, 0) + share * second.get(name, 0)
                for name in dict.fromkeys([*act, *second])
            }
        if generator.random() < _ADDED:
            own = expand_sides({str(generator.choice(_MORE)): float(generator.uniform(0.3, 0.9))}, ARKIT_NAMES)
            act = act | {name: max(value, act.get(name, 0)) for name, value in own.items()}
        tilt = generator.normal(0, _UNEVEN / 2)
        acts.append({name: float(np.clip(value * _side(name, tilt), 0, 1)) for name, value in act.items()})
    return acts


def _times(act: Mapping[str, float], strength: float) -> dict[str, float]:
    return {name: strength * weight for name, weight in act.items()}


def _side(name: str, tilt: float) -> float:
    """Factor of an action where the left side does so much more than the right one."""
    return 1 + tilt * (name.endswith("Left") - name.endswith("Right"))
