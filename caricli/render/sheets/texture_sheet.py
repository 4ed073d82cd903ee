"""A picture, and the head that was painted with it."""

from dataclasses import replace

import numpy as np

from caricli.render.face_look import face_look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.crop_portrait import crop_portrait
from caricli.render.views import VIEWS, render_views
from caricli.structures import Rig


def texture_sheet(
    picture: np.ndarray, points: np.ndarray, rig: Rig, size: int, sky: np.ndarray | None = None
) -> np.ndarray:
    """The face in its picture, and the textured head from all sides.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, landmarks in it, NaN where unknown. rig: Rig of the textured head.
    size: pixels of each. sky: (V, D) of its mesh as `mesh_sky` gives it, or None.
    Returns (H, W, 3) uint8.
    """
    sides = render_views(rig.face.mesh, VIEWS, size, replace(face_look(rig.face), visibility=sky))
    return contact_sheet([crop_portrait(picture, points, size), *sides], 4)
