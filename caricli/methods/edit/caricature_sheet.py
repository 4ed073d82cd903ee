"""The picture of a face that is made a caricature."""

from collections.abc import Sequence

import numpy as np

from caricli.methods.faces.draw_face import FaceDrawing
from caricli.render.sheets.view_sheets import film_strip
from caricli.structures import Face


def caricature_sheet(
    degrees: Sequence[Face], strengths: Sequence[float], drawing: FaceDrawing, portrait: np.ndarray | None = None
) -> np.ndarray:
    """Degrees of exaggeration beside each other.

    degrees: Faces. strengths: of each. drawing: FaceDrawing of the model. portrait: (H, H, 3) uint8, the picture that
    the face comes from, to be shown first.
    Returns (H, W, 3) uint8.
    """
    heads = [drawing.draw(face) for face in degrees]
    labels = [f"{strength:g}" for strength in strengths]
    if portrait is not None:
        heads.insert(0, [portrait])
        labels.insert(0, "given")
    return film_strip(heads, labels)
