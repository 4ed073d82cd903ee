"""How much light comes to what is inside a mouth."""

import numpy as np

from caricli.structures.materials import IN_MOUTH, Material

_THROAT = 0.1
"""Share of the light that comes to the backmost of what is inside the mouth, of that before its foremost tooth."""


def mouth_light(vertices: np.ndarray, faces: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """(V,) float32 share of the light that comes to vertices of teeth, gums and tongue, others 1.

    It falls off from front to back: most viewers let light through cheeks, and show the throat as bright as lips.
    vertices: (V, 3), +z front. faces: (F, 3). materials: (F,) Material of each.
    """
    inside = np.unique(faces[np.isin(materials, IN_MOUTH)])
    light = np.ones(len(vertices), np.float32)
    if len(inside):
        teeth = np.unique(faces[materials == Material.TEETH])
        front = vertices[inside, 2]
        foremost = vertices[teeth, 2].max() if len(teeth) else front.max()
        depth = np.clip((foremost - front) / max(foremost - front.min(), np.finfo(float).tiny), 0, 1)
        light[inside] = _THROAT + (1 - _THROAT) * (1 - depth) ** 2
    return light
