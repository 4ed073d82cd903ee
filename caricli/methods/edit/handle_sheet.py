"""Pictures of an edit by handles."""

from dataclasses import replace

import numpy as np

from caricli.methods.edit.deform_arap import deform_arap
from caricli.methods.edit.edit_handles import HandleEdit, edit_handles
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.faces.encode_face import EncodedFace
from caricli.render.sheets.view_sheets import film_strip, view_rows

VIEWS = ("front", "three-quarter", "profile")


def handle_sheet(before: EncodedFace, edit: HandleEdit, drawing: FaceDrawing, baseline: bool = False) -> np.ndarray:
    """The face before and after in three views.

    before: EncodedFace that was edited. edit: HandleEdit. drawing: FaceDrawing of the model.
    baseline: add the same handles as rigid as possible.
    Returns (H, W, 3) uint8.
    """
    rows = [drawing.draw(before, VIEWS), drawing.draw(edit.face, VIEWS)]
    labels = ["before", "after"]
    if baseline:
        tried = edit.tried
        rigid = deform_arap(before.vertices, before.faces, tried.vertices, tried.displacements)
        rows.append(drawing.draw(replace(before.posed(rigid), teeth=before.teeth), VIEWS))
        labels.append("as rigid as possible")
    return view_rows(rows, labels)


def handle_strip(before: EncodedFace, edit: HandleEdit, drawing: FaceDrawing, steps: int) -> np.ndarray:
    """A film strip of the same edit by equal steps, from none of it to all of it.

    steps: number of faces, at least 2; the other arguments and the result are those of ``handle_sheet``.
    """
    shares = np.linspace(0, 1, steps)
    edits = [edit_handles(before, drawing.model, edit.tried.scaled(share), edit.settings) for share in shares]
    return film_strip([drawing.draw(each.face) for each in edits], [f"{100 * share:.0f} %" for share in shares])
