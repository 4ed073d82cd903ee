"""Random neutral people."""

from dataclasses import dataclass

import numpy as np

PARTS = ("cheek", "chin", "ear-", "eyebrow", "eye-", "forehead", "head-", "mouth", "nose")
MORE = ("neck-double-incr",)
# Changes that move the whole head or turn it tell no identity; sideways shifts are nearly always accidents.
EXCLUDED = ("head-trans-forward", "head-trans-up", "head-trans-out", "head-angle-out")
# Large moves of ears and skull would drown what happens in the face.
DAMPED = {
    **dict.fromkeys(("mouth-trans-out", "nose-trans-out", "forehead-nubian-incr", "head-back-scale-depth-incr"), 0.3),
    **dict.fromkeys(("forehead-scale-vert-incr", "head-scale-vert-incr", "head-scale-horiz-incr"), 0.6),
    **dict.fromkeys(("l-ear-trans-up", "l-ear-trans-forward", "l-ear-shape-triangle", "l-ear-flap-incr"), 0.5),
}
ASYMMETRY = 0.12


@dataclass(frozen=True)
class Identity:
    """What makes a person: arguments of ``Head.evaluate``."""

    gender: float
    age: float
    weight: float
    changes: dict


def random_identity(head, generator):
    """Draw a person: gender, age and weight uniform, local changes normal, left and right coupled.

    head: Head. generator: numpy Generator.
    Returns Identity.
    """
    names = [n for n in head.change_names if (any(p in n for p in PARTS) or n in MORE) and n not in EXCLUDED]
    spread = generator.uniform(0.4, 0.9)
    changes = {}
    for name in names:
        weight = spread * generator.normal() * DAMPED.get(name, 1.0)
        if name.startswith("r-"):
            weight = changes["l-" + name[2:]] + ASYMMETRY * weight
        changes[name] = float(np.clip(weight, -1.6, 1.6))
    gender, weight = generator.uniform(0, 1, 2)
    return Identity(float(gender), float(generator.uniform(0.55, 1)), float(weight), changes)
