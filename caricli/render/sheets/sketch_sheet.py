"""A sketch and the face that was made of it."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from caricli.render.backdrop import blank_paper
from caricli.render.coat import mesh_coat
from caricli.render.face_look import head_look
from caricli.render.head_views import head_sky, head_views
from caricli.render.shade import Look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.overlay import overlay_mesh
from caricli.structures import Face
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from caricli.structures.zoomed_pixels import zoomed_pixels
from caricli.template.fine_mesh import FineMesh
from caricli.template.template import Template

_INK = {
    StrokeKind.SILHOUETTE: (190, 40, 40),
    StrokeKind.FEATURE: (30, 80, 190),
    StrokeKind.WRINKLE: (40, 40, 40),
    StrokeKind.UNKNOWN: (120, 120, 120),
}
"""As in figure 3 of the sketch paper."""
_CURVE = (240, 150, 20)
_BITS = 4
_FAR = 1 << 13


def sketch_sheet(
    face: Face,
    head: Template,
    sketch: Sketch,
    curves: Mapping[str, np.ndarray],
    image: np.ndarray | None = None,
    fine: FineMesh | None = None,
) -> np.ndarray:
    """The drawn sketch in the colours of its kinds, the face in it with its curves and the drawn lines, three views.

    face: Face with the camera of the canvas. head: Template in the shape of the face, a WholeHead where it has parts.
    sketch: Sketch. curves: (M, 2) pixels by names, of the face. image: (H, W, 3) uint8, what the sketch was drawn over,
    or None for paper. fine: FineMesh in the face's shape, to draw in the views.
    Returns (H, W, 3) uint8. Raises InputError when the face has no camera.
    """
    size = 512
    camera = face.require_camera()
    zoom = size / max(sketch.size)
    paper = _paper(sketch, image, size)
    width = max(1, round(size / 256))
    drawn = _with_lines(paper, sketch.strokes, zoom, width)
    mesh, plain = head_look(head)
    sky = head_sky(head)
    before = replace(plain, visibility=sky, rotation=camera.rotation)
    over = overlay_mesh(paper, mesh, camera.zoomed(zoom), look=before)
    over = _with_lines(over, sketch.strokes, zoom, 1)
    for line in curves.values():
        over = _polyline(over, line, zoom, _CURVE, 1)
    look = Look(coat=mesh_coat(face.mesh if fine is None else fine.mesh, face.pictures), visibility=sky)
    views = head_views(head, ("front", "three-quarter", "profile"), size, fine, look)
    return contact_sheet([drawn, over, *views], 5)


def _paper(sketch: Sketch, image: np.ndarray | None, size: int) -> np.ndarray:
    """(S, S, 3) uint8: what a sketch was drawn over, its longer side as long as the picture; the rest is paper."""
    from PIL import Image

    width, height = sketch.size
    picture = blank_paper(size, size)
    if image is None:
        return picture
    zoom = size / max(width, height)
    shape = (max(1, round(height * zoom)), max(1, round(width * zoom)))
    picture[: shape[0], : shape[1]] = np.asarray(Image.fromarray(image).resize(shape[::-1], Image.Resampling.LANCZOS))
    return picture


def _with_lines(picture: np.ndarray, strokes: Iterable[Stroke], zoom: float, width: int) -> np.ndarray:
    """Strokes in the colours of their kinds over a picture (H, W, 3) uint8."""
    for stroke in strokes:
        picture = _polyline(picture, stroke.points, zoom, _INK[stroke.kind], width)
    return picture


def _polyline(picture: np.ndarray, line: np.ndarray, zoom: float, colour: tuple[int, ...], width: int) -> np.ndarray:
    import cv2

    pixels = np.clip(zoomed_pixels(line, zoom), -_FAR, _FAR)
    fixed = np.rint(pixels * (1 << _BITS)).astype(np.int32)
    return cv2.polylines(picture.copy(), [fixed], False, colour, width, cv2.LINE_AA, _BITS)
