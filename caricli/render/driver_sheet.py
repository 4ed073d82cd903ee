"""A normal face and the caricature that does the same."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.draw_rig import draw_rig
from caricli.render.head_views import head_views
from caricli.structures import Rig
from caricli.template.template import Template

SIZE = 384
"""Side of one picture, pixels."""


def driver_sheet(driver: Template, rig: Rig, vertices: np.ndarray) -> np.ndarray:
    """Both beside each other from the front. vertices: (V, 3) metres, of the rig. Returns (H, W, 3) uint8."""
    pictures = [*head_views(driver, ("front",), SIZE), draw_rig(rig, vertices, "front", SIZE)]
    return contact_sheet(pictures, 2, ["driver", "caricature"])
