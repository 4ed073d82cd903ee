"""A normal face and the caricature that does the same."""

import numpy as np

from caricli.render.head_views import head_views
from caricli.render.rig_stage import RigStage
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.structures import Face, Rig
from caricli.template.template import Template

SIZE = 384
"""Side of one picture, pixels."""


def driver_stage(rig: Rig) -> RigStage:
    """The stage of a rig for its sheets, which share it."""
    return RigStage(rig, "front", SIZE)


def driver_sheet(driver: Template, stage: RigStage, face: Face) -> np.ndarray:
    """Both beside each other from the front.

    driver: Template in the shape of the normal face. stage: of `driver_stage`. face: Face of its rig, as it moved.
    Returns (H, W, 3) uint8.
    """
    drawn = stage.picture(face.vertices, face.pictures.skin)
    pictures = [*head_views(driver, ("front",), SIZE), drawn]
    return contact_sheet(pictures, 2, ["driver", "caricature"])
