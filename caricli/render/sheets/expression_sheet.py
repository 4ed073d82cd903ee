"""All expressions of a rig beside each other."""

from collections.abc import Callable

import numpy as np

from caricli.render.rig_stage import RigStage
from caricli.render.sheets.contact_sheet import contact_sheet
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
    pictures = []
    for picture in RigStage(rig, "front", SIZE).pictures(shapes.values()):
        pictures.append(picture)
        progress(len(pictures), len(shapes))
    return contact_sheet(pictures, min(COLUMNS, len(pictures)), [*shapes])
