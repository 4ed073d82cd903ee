"""A sketch and the face that was made of it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

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
_SMALL = 0.6
"""Of the canvas: a drawing that takes less of it is come near to."""
_AROUND = 1.15
"""How large what is shown then is, in sizes of the drawing."""


@dataclass(frozen=True)
class _Window:
    """What is shown of a canvas. zoom, corner: as ``zoomed_pixels`` has them."""

    zoom: float
    corner: np.ndarray | tuple[float, float] = (0.0, 0.0)


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
    or None for paper, of which a drawing that takes little is come near to. fine: FineMesh in the face's shape, to draw
    in the views.
    Returns (H, W, 3) uint8. Raises InputError when the face has no camera.
    """
    size = 512
    camera = face.require_camera()
    window = _window(sketch, curves, size) if image is None else _Window(size / max(sketch.size))
    paper = _paper(sketch, image, size)
    width = max(1, round(size / 256))
    drawn = _with_lines(paper, sketch.strokes, window, width)
    mesh, plain = head_look(head)
    sky = head_sky(head)
    before = replace(plain, visibility=sky, rotation=camera.rotation)
    over = overlay_mesh(paper, mesh, camera.zoomed(window.zoom, window.corner), look=before)
    over = _with_lines(over, sketch.strokes, window, 1)
    for line in curves.values():
        over = _polyline(over, line, window, _CURVE, 1)
    look = Look(coat=mesh_coat(face.mesh if fine is None else fine.mesh, face.pictures), visibility=sky)
    views = head_views(head, ("front", "three-quarter", "profile"), size, fine, look)
    return contact_sheet([drawn, over, *views], 5)


def _window(sketch: Sketch, curves: Mapping[str, np.ndarray], size: int) -> _Window:
    """The whole canvas, or what is around a drawing and a face that take little of it. size: pixels to draw."""
    side = max(sketch.size)
    lines = np.concatenate([*(stroke.points for stroke in sketch.strokes), *curves.values()])
    near = _AROUND * float(np.ptp(lines, axis=0).max())
    if not 0 < near < _SMALL * side:
        return _Window(size / side)
    return _Window(size / near, (lines.min(0) + lines.max(0)) / 2 + 0.5 - near / 2)


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


def _with_lines(picture: np.ndarray, strokes: Iterable[Stroke], window: _Window, width: int) -> np.ndarray:
    """Strokes in the colours of their kinds over a picture (H, W, 3) uint8."""
    for stroke in strokes:
        picture = _polyline(picture, stroke.points, window, _INK[stroke.kind], width)
    return picture


def _polyline(
    picture: np.ndarray, line: np.ndarray, window: _Window, colour: tuple[int, ...], width: int
) -> np.ndarray:
    import cv2

    pixels = np.clip(zoomed_pixels(line, window.zoom, window.corner), -_FAR, _FAR)
    fixed = np.rint(pixels * (1 << _BITS)).astype(np.int32)
    return cv2.polylines(picture.copy(), [fixed], False, colour, width, cv2.LINE_AA, _BITS)
