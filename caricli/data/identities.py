"""Random neutral people."""

from dataclasses import dataclass

import numpy as np

from caricli.template.head import Head

PARTS = ("cheek", "chin", "ear-", "eyebrow", "eye-", "forehead", "head-", "mouth", "nose")
"""What stands in the names of changes that are drawn."""

FURTHER = ("neck-double-incr",)
"""Names of changes that are drawn, too."""

EXCLUDED = ("head-trans-forward", "head-trans-up", "head-trans-out", "head-angle-out")
"""Changes that move the whole head or turn it tell no identity; sideways shifts are nearly always accidents."""

DAMPED = {
    **dict.fromkeys(("mouth-trans-out", "nose-trans-out", "forehead-nubian-incr", "head-back-scale-depth-incr"), 0.3),
    **dict.fromkeys(("forehead-scale-vert-incr", "head-scale-vert-incr", "head-scale-horiz-incr"), 0.6),
    **dict.fromkeys(("l-ear-trans-up", "l-ear-trans-forward", "l-ear-shape-triangle", "l-ear-flap-incr"), 0.5),
}
"""Factors of changes: large moves of ears and skull would drown what happens in the face."""

ASYMMETRY = 0.12
"""How far the right side differs from the left, a share of a change's own draw."""

SPREAD = (0.4, 0.9)
"""Standard deviation of a person's changes, uniform between these: some people are more usual than others."""

MAX_CHANGE = 1.6
"""Of a change's weight: beyond it the head's own shapes tear."""

YOUNGEST = 0.55
"""Age on the head's scale from 0, a baby, to 1: adults, whose faces caricaturists draw."""


def usual_size(name: str) -> float:
    """How large a local change usually is among people; 0 for what is not drawn."""
    if name in EXCLUDED or not (any(part in name for part in PARTS) or name in FURTHER):
        return 0.0
    return sum(SPREAD) / 2 * DAMPED.get("l-" + name[2:] if name.startswith("r-") else name, 1.0)


@dataclass(frozen=True)
class Identity:
    """What makes a person: arguments of ``Head.evaluate``.

    gender, age, weight: from 0 to 1. changes: weights of the head's local changes by name.
    """

    gender: float
    age: float
    weight: float
    changes: dict[str, float]


def random_identity(head: Head, generator: np.random.Generator) -> Identity:
    """Draw a person: gender, age and weight uniform, local changes normal, left and right coupled."""
    names = [name for name in head.change_names if usual_size(name)]
    spread = generator.uniform(*SPREAD)
    changes: dict[str, float] = {}
    for name in names:
        change = spread * generator.normal() * DAMPED.get(name, 1.0)
        if name.startswith("r-"):
            change = changes["l-" + name[2:]] + ASYMMETRY * change
        changes[name] = float(np.clip(change, -MAX_CHANGE, MAX_CHANGE))
    gender, weight = generator.uniform(0, 1, 2)
    age = generator.uniform(YOUNGEST, 1)
    return Identity(float(gender), float(age), float(weight), changes)
