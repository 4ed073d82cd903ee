"""What the network is shown of a sketch."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.along_lines import along
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

FILL = 0.86
"""Of a window's half side: the reach of the strokes from its middle."""

CANVAS_FILL = 0.72
"""The same of the mean head's curves where the window is a canvas, on which larger heads have room."""

POINTS = 16
"""Along every curve, its ends included."""

_SMALLEST = 1e-3
"""Of the canvas's side: a sketch that is no larger is a dot."""


@dataclass(frozen=True, eq=False)
class Window:
    """A square around the strokes of a sketch; its own coordinates go from -1 to 1.

    centre: (2,) pixels of the canvas. half: pixels, half of its side.
    """

    centre: np.ndarray
    half: float

    @classmethod
    def around(cls, lines: Sequence[np.ndarray], side: float) -> "Window":
        """The window of lines (N, 2), pixels. side: of the canvas. Raises InputError where they are but a dot."""
        points = np.concatenate([np.zeros((0, 2)), *lines])
        if not len(points) or np.ptp(points, axis=0).max() <= _SMALLEST * side:
            raise InputError("expected a sketch with lines, found an empty one" if not len(points) else _DOT)
        low = points.min(0)
        high = points.max(0)
        return cls((low + high) / 2, float((high - low).max() / 2 / FILL))

    def inside(self, points: np.ndarray) -> np.ndarray:
        """Pixels of the canvas (..., 2) in the window's coordinates."""
        return (points - self.centre) / self.half


_DOT = "expected a sketch with lines, found a dot"


def shown_strokes(sketch: Sketch, curves: Sequence[str]) -> list[Stroke]:
    """The strokes that the network looks at: wrinkles only where they are one of its curves."""
    return [stroke for stroke in sketch.strokes if stroke.kind != StrokeKind.WRINKLE or stroke.curve in curves]


def curve_points(strokes: Sequence[Stroke], window: Window, curves: Sequence[str], usual: np.ndarray) -> np.ndarray:
    """Points (K, P, 2) along the named strokes in the window's coordinates, NaN where a curve is not drawn.

    Of several strokes of a curve the longest counts. A line runs in the direction in which its points are nearer to
    where they usually are: usual (K, P, 2).
    """
    points = np.full(usual.shape, np.nan)
    lengths: dict[str, float] = {}
    for stroke in strokes:
        name = stroke.curve
        if name is None or name not in curves or len(stroke.points) < 2 or stroke.length <= lengths.get(name, 0):
            continue
        lengths[name] = stroke.length
        row = curves.index(name)
        line = along(window.inside(stroke.points)[None], np.linspace(0, 1, usual.shape[1])[None])[0]
        centred = usual[row] - usual[row].mean(0)
        points[row] = line if (centred * (line - line[::-1])).sum() >= 0 else line[::-1]
    return points
