"""A head before and after it was painted."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.face_look import face_look
from caricli.render.head_views import head_views
from caricli.render.views import VIEWS, render_views
from caricli.structures import Rig
from caricli.template.template import Template

_FIRST = ("front", "three-quarter", "profile")


def texture_sheet(head: Template, rig: Rig, size: int) -> np.ndarray:
    """Picture of the plain head from three sides, and of the textured one from all.

    head: Template in the shape of the face, a WholeHead where it has parts. rig: Rig of the textured head. size: pixels
    of one view.
    Returns (H, W, 3) uint8.
    """
    plain = head_views(head, _FIRST, size)
    others = [view for view in VIEWS if view not in _FIRST]
    textured = render_views(rig.face.mesh, [*_FIRST, *others], size, face_look(rig.face))
    return contact_sheet([*plain, *textured], 3, ["before", "", "", "after", "", "", "", "", ""])
