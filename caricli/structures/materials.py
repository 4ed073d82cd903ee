"""What polygons are made of."""

from enum import IntEnum

import numpy as np


class Material(IntEnum):
    """What a polygon is made of."""

    SKIN = 0
    EYE = 1


def material_problem(materials: np.ndarray | None, polygons: int) -> str | None:
    """What is wrong with the materials (P,) of so many polygons, or None."""
    if materials is None:
        return None
    values = np.asarray(materials)
    if values.shape != (polygons,) or not np.isin(values, [*Material]).all():
        return f"materials: expected {[*map(int, Material)]} for every polygon, found others"
    return None
