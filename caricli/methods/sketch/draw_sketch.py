"""The lines of a head as a camera sees them."""

import numpy as np

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.structures.camera import Camera
from caricli.structures.sketch import CANVAS, Sketch, Stroke
from caricli.template.feature_curves import FeatureCurve

FILL = 0.86
"""Of a canvas's side: the longer side of what is drawn on it."""


def draw_curves(vertices: np.ndarray, curves: tuple[FeatureCurve, ...], camera: Camera) -> tuple[Stroke, ...]:
    """Strokes of the curves of a head, whether they are seen or not (section 5.1 of the sketch paper says why).

    vertices: (V, 3) metres. curves: as ``feature_curves`` gives them. camera: Camera.
    Returns a Stroke for every curve, in their order, with its name.
    """
    return tuple(Stroke(camera.project(vertices[c.vertices]), c.kind, c.name) for c in curves)


def draw_sketch(
    vertices: np.ndarray,
    curves: tuple[FeatureCurve, ...],
    camera: Camera,
    size: tuple[int, int] = (CANVAS, CANVAS),
) -> Sketch:
    """A Sketch of the curves of a head, without further lines.

    vertices, curves, camera: as in ``draw_curves``. size: (width, height) of the canvas, pixels.
    """
    return Sketch(draw_curves(vertices, curves, camera), size)


def canvas_camera(
    vertices: np.ndarray,
    curves: tuple[FeatureCurve, ...],
    view: tuple[float, float] = (0.0, 0.0),
    side: int = CANVAS,
    fill: float = FILL,
) -> Camera:
    """The camera that sees the curves of a head in the middle of a square canvas.

    vertices: (V, 3) metres. curves: FeatureCurves. view: yaw and pitch of the head in degrees; a positive yaw looks to
    the right of the picture, a positive pitch down. side: pixels. fill: of the side, the longer side of their box.
    """
    ids = np.unique(np.concatenate([curve.vertices for curve in curves]))
    return framing_camera(vertices[ids], view, side, fill)


def framing_camera(points: np.ndarray, view: tuple[float, float], side: int, fill: float = FILL) -> Camera:
    """The camera that sees points (N, 3) in the middle of a square canvas; the rest as in ``canvas_camera``."""
    rotation = head_rotation(np.radians([view[1], -view[0], 0.0]))
    flat = points @ rotation[:2].T
    scale = fill * side / max(np.ptp(flat, axis=0).max(), 1e-6)
    middle = (flat.min(0) + flat.max(0)) / 2
    return Camera(float(scale), rotation, (side - 1) / 2 - scale * middle)
