"""How much light comes to what is inside a mouth."""

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.structures.materials import IN_MOUTH, Material, toned

_THROAT = 0.1
"""Share of the light that comes to the back of the mouth, of that before the foremost tooth."""

_SHADE = 0.6
"""Of the depth of the arch of teeth: from there on it is as dark as that."""

_TINT = (1.0, 1.3, 1.4)
"""Exponents of red, green and blue: what light is left there comes from gums and cheeks."""


def mouth_light(vertices: np.ndarray, faces: np.ndarray, materials: np.ndarray, coloured: float = 1.0) -> np.ndarray:
    """(V, 3) float32 shares of linear light that come to vertices of teeth, gums and tongue, others 1.

    It falls off from the front to the back of the arch: most viewers let light through cheeks, and show the throat as
    bright as lips, and molars at the corners of an open mouth as tusks. Without teeth, tongue and gums are the arch.
    vertices: (V, 3), +z front. faces: (F, 3). materials: (F,) Material of each. coloured: from 0, of a head in shades
    of grey, to 1.
    """
    inside = np.unique(faces[np.isin(materials, IN_MOUTH)])
    light = np.ones((len(vertices), 3), np.float32)
    if len(inside):
        teeth = np.unique(faces[materials == Material.TEETH])
        arch = vertices[teeth if len(teeth) else inside, 2]
        depth = (arch.max() - vertices[inside, 2]) / max(_SHADE * np.ptp(arch), np.finfo(float).tiny)
        share = 1 - (1 - _THROAT) * smooth_step(depth, 0, 1)
        light[inside] = share[:, None] ** toned(np.array(_TINT), coloured)
    return light
