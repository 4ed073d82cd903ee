"""The picture of an edit by handles."""

import numpy as np

from caricli.methods.edit.deform_arap import deform_arap
from caricli.methods.edit.edit_handles import HandleEdit
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.render.head_views import head_views
from caricli.render.view_sheets import view_rows
from caricli.structures import Face

VIEWS = ("front", "three-quarter", "profile")


def handle_sheet(before: Face, edit: HandleEdit, drawing: FaceDrawing, baseline: bool = False) -> np.ndarray:
    """The face before and after in three views.

    before: Face that was edited. edit: HandleEdit. drawing: FaceDrawing of the model. baseline: add the same handles
    as rigid as possible.
    Returns (H, W, 3) uint8.
    """
    rows = [drawing.draw(before, VIEWS), drawing.draw(edit.face, VIEWS)]
    labels = ["before", "after"]
    if baseline:
        handles = edit.handles.scaled(edit.share)
        rigid = deform_arap(before.vertices, before.faces, handles.vertices, handles.displacements)
        rows.append(head_views(drawing.model.template.with_vertices(rigid), VIEWS, drawing.size))
        labels.append("as rigid as possible")
    return view_rows(rows, labels)
