"""One portrait and what was made of it, in a row."""

from collections.abc import Sequence

import cv2
import numpy as np

from caricli.render.backdrop import blank_paper, on_backdrop
from caricli.render.face_look import face_look, head_look
from caricli.render.sheets.fit_sheet import FITTED, GIVEN
from caricli.render.sheets.overlay import draw_landmarks, overlay_mesh
from caricli.render.views import render_views
from caricli.structures import Face, Rig
from caricli.structures.zoomed_pixels import zoomed_pixels
from caricli.template.template import Template

SIDES = ("three-quarter", "three-quarter-right")
"""Views of the textured head."""


def portrait_row(
    image: np.ndarray,
    given: np.ndarray,
    fits: Sequence[tuple[Face, Template] | None],
    rig: Rig,
    size: int,
) -> list[np.ndarray]:
    """The picture; every face that was fitted to it, in its place; and a textured head from two sides.

    image: (H, W, 3) uint8. given: (L, 2) pixels, NaN where unknown: green circles, beside the red dots of the fitted
    ones. fits: Faces with camera and landmarks, each with a Template in its shape, a WholeHead where it has parts; the
    picture itself in place of None. rig: Rig of the textured head. size: pixels, the longer side of each.
    """
    zoom = size / max(image.shape[:2])
    picture = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    fitted = [picture if fit is None else _fit(picture, zoom, given, *fit) for fit in fits]
    sides = render_views(rig.face.mesh, SIDES, size, face_look(rig.face))
    return [picture, *fitted, *map(on_backdrop, sides)]


def _fit(picture: np.ndarray, zoom: float, given: np.ndarray, face: Face, head: Template) -> np.ndarray:
    """A fitted face on paper, with the landmarks."""
    mesh, look = head_look(head)
    paper = blank_paper(*picture.shape[:2])
    drawn = overlay_mesh(paper, mesh, face.require_camera().zoomed(zoom), opacity=1, look=look)
    drawn = draw_landmarks(drawn, zoomed_pixels(given, zoom), GIVEN, radius=2, hollow=True, lines=False)
    return draw_landmarks(drawn, zoomed_pixels(face.require_landmarks(), zoom), FITTED, radius=1, lines=False)
