"""Shapes between two shapes."""

import numpy as np

from caricli.geometry.deformation_gradients import DeformationGradients
from caricli.geometry.untangle import untangle

ROUNDS = 20
"""Of `untangle`: so many turn back all that can be, as both ends are whole."""


def interpolate_shapes(
    first: np.ndarray, second: np.ndarray, weight: float, gradients: DeformationGradients
) -> np.ndarray:
    """Blend the deformation features of two shapes and solve: what turns, turns, and nothing shrinks on the way.

    Where blended rings do not fit each other (nostrils, lids), triangles can flip that are whole at both ends; they are
    turned back.

    first, second: (V, 3). weight: 0 gives the first, 1 the second. gradients: DeformationGradients of the template.
    Returns (V, 3).
    """
    if weight in (0, 1):
        return (second if weight else first).copy()
    features = (1 - weight) * gradients.features(first) + weight * gradients.features(second)
    means = gradients.components.averages @ ((1 - weight) * first + weight * second)
    return untangle(gradients.components.place(gradients.vertices(features), means), gradients, ROUNDS)
