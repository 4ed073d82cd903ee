"""How well a morphable model tells who from what."""

import numpy as np

from caricli.models.morphable.model import MorphableModel


def measure_separation(
    model: MorphableModel, shapes: np.ndarray, people: np.ndarray, shown: np.ndarray
) -> dict[str, float | None]:
    """Encode meshes and ask how much of each part's variance their groups explain.

    shapes: (N, V, 3) metres. people, shown: (N,) ints, who and which expression.
    Returns agreements, 1 where a part is the same within every group and 0 where groups do not matter; None where no
    group has two meshes. Exaggerations are part of the identity: people agree only as far as theirs do.
    """
    identity, expression = model.parts(model.encode(shapes))
    who = np.tensordot(identity, model.identity, 1)
    what = np.tensordot(expression, model.expression, 1)
    return {
        "identity_of_a_person": agreement(who, people),
        "identity_of_an_expression": agreement(who, shown),
        "expression_of_an_expression": agreement(what, shown),
        "expression_of_a_person": agreement(what, people),
    }


def agreement(values: np.ndarray, groups: np.ndarray) -> float | None:
    """One less the variance within groups over all variance; None where no group has two or nothing varies.

    values: (N, ...). groups: (N,). Groups of one tell nothing and are left out of the variance within.
    """
    if not len(values):
        return None
    flat = values.reshape(len(values), -1)
    _, numbers, counts = np.unique(groups, return_inverse=True, return_counts=True)
    total = flat.var(0).sum()
    several = counts[numbers] > 1
    if not several.any() or total == 0:
        return None
    means = np.zeros((len(counts), flat.shape[1]))
    np.add.at(means, numbers, flat)
    means /= counts[:, None]
    size = counts[numbers[several]]
    # A group's mean follows its own members: n / (n - 1) makes up for it.
    within = (((flat - means[numbers])[several] ** 2).sum(1) * size / (size - 1)).mean()
    return float(1 - within / total)
