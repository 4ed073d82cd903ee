"""A landmark fit on one picture: what was given, what was fitted, from several sides."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from caricli.render.backdrop import blank_paper
from caricli.render.coat import mesh_coat
from caricli.render.face_look import head_look
from caricli.render.head_views import head_sky, head_views
from caricli.render.in_parallel import in_parallel
from caricli.render.pixels.cut_square import cut_square
from caricli.render.shade import Look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.overlay import draw_landmarks, overlay_mesh
from caricli.structures import Face
from caricli.structures.zoomed_pixels import zoomed_pixels
from caricli.template.fine_mesh import FineMesh
from caricli.template.template import Template

GIVEN = (30, 160, 70)
FITTED = (215, 40, 40)
_MARGIN = 0.35  # of the larger side of what is shown, around it


def fit_sheet(
    face: Face,
    head: Template,
    given: np.ndarray,
    image: np.ndarray | None = None,
    size: int = 512,
    fine: FineMesh | None = None,
) -> np.ndarray:
    """Picture with given (green circles) and fitted (red) landmarks, mesh over the picture, three views.

    face: Face with the camera and the landmarks that were fitted. head: Template in the shape of the face, a WholeHead
    where it has parts. given: (L, 2) pixels, NaN where unknown. image: (H, W, 3) uint8, paper where there is none.
    size: pixels of one view. fine: FineMesh in the face's shape, to draw in the views.
    Returns (H, W, 3) uint8. Raises InputError when the face has no camera or no landmarks.
    """
    camera = face.require_camera()
    fitted = face.require_landmarks()
    corner, window = _window(given, camera.project(face.vertices) if image is None else None)
    zoom = size / window
    picture = _crop(image, corner, window, size)
    dotted = draw_landmarks(picture, zoomed_pixels(fitted, zoom, corner), FITTED)
    circle = max(1.5, size / 120)
    marked = draw_landmarks(dotted, zoomed_pixels(given, zoom, corner), GIVEN, radius=circle, hollow=True, lines=False)
    mesh, plain = head_look(head)
    sky = head_sky(head)
    before = replace(plain, visibility=sky, rotation=camera.rotation)
    look = Look(coat=mesh_coat(face.mesh if fine is None else fine.mesh, face.pictures), visibility=sky)
    drawings: list[Callable[[], list[np.ndarray]]] = [
        lambda: head_views(head, ("front", "three-quarter", "profile"), size, fine, look),
        lambda: [overlay_mesh(picture, mesh, camera.zoomed(zoom, corner), look=before)],
    ]
    views, over = in_parallel(lambda draw: draw(), drawings)
    return contact_sheet([marked, *over, *views], 5)


def _window(given: np.ndarray, projected: np.ndarray | None) -> tuple[np.ndarray, float]:
    """Corner (2,) and side, in pixels, of the square around the given landmarks and the mesh."""
    low = np.nanmin(given, axis=0)
    high = np.nanmax(given, axis=0)
    if projected is not None:
        low = np.minimum(low, projected.min(0))
        high = np.maximum(high, projected.max(0))
    window = float((high - low).max() * (1 + 2 * _MARGIN))
    return (low + high - window) / 2, window


def _crop(image: np.ndarray | None, corner: np.ndarray, window: float, size: int) -> np.ndarray:
    if image is None:
        return blank_paper(size, size)
    return cut_square(image, corner, window, size)
