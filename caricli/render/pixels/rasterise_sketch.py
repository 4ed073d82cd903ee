"""A sketch as pixels."""

import numpy as np

from caricli.structures.sketch import CANVAS, Sketch, Stroke

_BITS = 5
"""Of the fraction of a coordinate."""
_FAR = 2.0
"""Canvases beyond the border after which a point is pulled back: OpenCV counts in 16 bits."""
_SHADES = 8
"""Of pressure: neighbouring points of one shade are drawn together."""


def rasterise_sketch(sketch: Sketch, side: int = CANVAS, width: float = 1.0) -> np.ndarray:
    """Draw a sketch with smooth edges.

    sketch: Sketch; on a canvas of another size or shape it is centred and as large as fits. side: pixels, N. width:
    pixels of the picture, of strokes that have none of their own; lines are 1.4, 3.4, 5.4 ... pixels wide, whatever is
    nearest.
    Returns (N, N) uint8, 0 where nothing is drawn and 255 where ink is; less where a stroke was drawn with less
    pressure.
    """
    import cv2

    ink = np.zeros((side, side), np.uint8)
    zoom = side / max(sketch.size)
    place = (side - 1) / 2 - zoom * (np.array(sketch.size) - 1) / 2
    parts: dict[tuple[int, int], list[np.ndarray]] = {}
    for stroke in sketch.strokes:
        points = np.clip(stroke.points * zoom + place, -_FAR * side, (1 + _FAR) * side)
        fixed = np.rint(points * (1 << _BITS)).astype(np.int32)
        # What OpenCV calls a smooth line of thickness t is about 2 t - 0.6 pixels wide.
        thickness = max(round(((width if stroke.width is None else stroke.width * zoom) + 0.6) / 2), 1)
        for shade, line in _shaded(stroke, fixed):
            parts.setdefault((shade, min(thickness, side)), []).append(line)
    for shade, thickness in sorted(parts):  # the dark over the light
        cv2.polylines(ink, parts[shade, thickness], False, shade, thickness, cv2.LINE_AA, _BITS)
    return ink


def _shaded(stroke: Stroke, fixed: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """Pieces of a line with the shade of each."""
    if len(fixed) == 1:
        fixed = (fixed + np.array([[-(1 << _BITS) // 2, 0], [(1 << _BITS) // 2, 0]])).astype(np.int32)
    if stroke.pressure is None:
        return [(255, fixed)]
    between = (stroke.pressure[1:] + stroke.pressure[:-1]) / 2 if len(stroke.pressure) > 1 else stroke.pressure
    shades = np.rint(255 * np.rint(between * _SHADES) / _SHADES).astype(int)
    starts = np.flatnonzero(np.diff(shades, prepend=-1))
    ends = np.append(starts[1:], len(shades))
    return [
        (int(shades[start]), fixed[start : end + 1]) for start, end in zip(starts, ends, strict=True) if shades[start]
    ]
