"""A face before and after."""

import numpy as np

from caricli.methods.edit.handle_sheet import VIEWS
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.render.sheets.view_sheets import view_rows
from caricli.structures import Face


def refined_sheet(before: Face, after: Face, drawing: FaceDrawing) -> np.ndarray:
    """Both in three views, (H, W, 3) uint8. drawing: FaceDrawing of their model."""
    return view_rows([drawing.draw(before, VIEWS), drawing.draw(after, VIEWS)], ["before", "after"])
