"""All expressions of a rig beside each other."""

from collections.abc import Callable

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.draw_rig import draw_rig, neutral_sky
from caricli.structures import Rig

SIZE = 224
"""Side of one picture, pixels."""

COLUMNS = 9
"""Pictures in a row."""


def expression_sheet(rig: Rig, progress: Callable[[int, int], object], given: np.ndarray | None = None) -> np.ndarray:
    """A picture of the neutral face and every expression from the front.

    progress: called with finished pictures and their total. given: (V, 3) metres, another shape to begin with, or None.
    Returns (H, W, 3) uint8.
    """
    shapes = {} if given is None else {"as given": given}
    shapes["neutral"] = rig.neutral
    shapes |= {name: rig.shape_in_use(k) for k, name in enumerate(rig.names)}
    sky = neutral_sky(rig)
    pictures = []
    for shape in shapes.values():
        pictures.append(draw_rig(rig, shape, "front", SIZE, sky))
        progress(len(pictures), len(shapes))
    return contact_sheet(pictures, min(COLUMNS, len(pictures)), [*shapes])
