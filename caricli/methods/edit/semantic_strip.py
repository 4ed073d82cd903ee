"""The picture of an edit by labels."""

import numpy as np

from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.faces.encode_face import EncodedFace
from caricli.render.sheets.view_sheets import film_strip


def semantic_strip(face: EncodedFace, edit: SemanticEdit, drawing: FaceDrawing, steps: int | None = None) -> np.ndarray:
    """The face before beside after, or in equal steps from minus to plus the strengths.

    face: EncodedFace before. edit: SemanticEdit. drawing: FaceDrawing of the model. steps: number of faces, or None.
    Returns (H, W, 3) uint8.
    """
    shares = np.linspace(-1, 1, steps) if steps else np.array([0.0, 1.0])
    faces = [edit_semantic(face, drawing.model, edit.scaled(share)) for share in shares]
    labels = [_step_label(edit, share) for share in shares] if steps else ["before", "after"]
    return film_strip([drawing.draw(each) for each in faces], labels)


def _step_label(edit: SemanticEdit, share: float) -> str:
    """The strength of one label; of several, or none, the share."""
    strengths = list(edit.strengths.values())
    if len(strengths) == 1 and strengths[0]:
        return f"{share * strengths[0]:+.3g}"
    return f"{100 * share:+.0f} %"
