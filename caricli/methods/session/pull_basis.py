"""How a face follows a point while it is dragged, near enough to be seen."""

import numpy as np

from caricli.methods.edit.edit_handles import HandleSettings, edit_handles
from caricli.methods.edit.handle_points import handle_points
from caricli.methods.parts.face_parts import face_parts
from caricli.methods.session.pose import DRESSED
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Face

_STEP = 0.01
"""Of the head's height: how far the point is pulled to see where the others go."""

_QUICK = HandleSettings(rounds=2, corrections=1, untangling=1)


def pull_basis(work: Work, where: str, tools: Tools, symmetric: bool = False) -> np.ndarray:
    """What a metre of a point's way along x, y and z does to all vertices of the face at rest and of its parts.

    To the first order: whoever lets the point go gets what the operation ``handle`` makes of it.

    where: a vertex or a name. symmetric: whether the other side does the same. Returns (3, V + P, 3), the parts as
    ``dressed_vertices`` has them. Raises InputError.
    """
    head = tools.model.template.with_vertices(work.face.vertices)
    step = _STEP * head.height
    before = dressed_vertices(work.face, tools)
    ways = []
    for axis in range(3):
        lengths = [0.0, 0.0, 0.0]
        lengths[axis] = step
        handles = handle_points([(where, lengths)], (), head, symmetric)
        edit = edit_handles(work.face, tools.model, handles, _QUICK)
        ways.append((dressed_vertices(edit.face, tools) - before) / step)
    return np.array(ways)


def dressed_vertices(face: Face, tools: Tools) -> np.ndarray:
    """(V + P, 3) metres: the vertices of a Face and of its parts, those of DRESSED, after each other."""
    parts = face_parts(face, tools.model.template, DRESSED)
    return np.concatenate([face.vertices, *(part.mesh.vertices for part in parts)])
