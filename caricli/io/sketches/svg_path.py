"""The lines of an SVG's shapes as points."""

import re
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.sketches.svg_view import Window, lengths_of
from caricli.limits import MAX_SKETCH_POINTS

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_STEP = 2.0
"""Pixels between the points of a curve, about."""
_FEWEST = 4
_MOST = 256
"""Pieces that a curve becomes."""


def outline_points(element: Element, name: str, scale: float, window: Window | None) -> Iterator[np.ndarray]:
    """The lines (N, 2) of a shape in its own units.

    element: path, line, polyline, polygon, rect, circle or ellipse. name: which of them. scale: pixels of a unit.
    window: size of the drawing that it lies in, which percents are of.
    Yields points, of a path a line for every part that begins with a move. Raises InputError when it is malformed.
    """
    if name == "path":
        yield from _path(element.get("d") or "", scale)
    elif name in ("polyline", "polygon"):
        points = _numbers(element.get("points") or "")
        points = points[: len(points) // 2 * 2].reshape(-1, 2)
        if len(points):
            yield np.vstack([points, points[:1]]) if name == "polygon" else points
    else:
        yield from _SHAPES[name](element, window)


def _numbers(text: str) -> np.ndarray:
    words = _NUMBER.findall(text)
    if len(words) > 2 * MAX_SKETCH_POINTS:
        raise InputError(f"expected at most {MAX_SKETCH_POINTS} points, found more")
    return np.array([float(word) for word in words])


def _line(element: Element, window: Window | None) -> Iterator[np.ndarray]:
    yield np.array(lengths_of(element, ("x1", "y1", "x2", "y2"), window)).reshape(2, 2)


def _rectangle(element: Element, window: Window | None) -> Iterator[np.ndarray]:
    x, y, width, height = lengths_of(element, ("x", "y", "width", "height"), window)
    if width > 0 and height > 0:
        yield np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])


def _ellipse(element: Element, window: Window | None) -> Iterator[np.ndarray]:
    x, y, radius, wide, high = lengths_of(element, ("cx", "cy", "r", "rx", "ry"), window)
    radii = np.array([wide or high or radius, high or wide or radius])
    if (radii > 0).all():
        angles = np.linspace(0, 2 * np.pi, 65)
        points = np.column_stack([np.cos(angles), np.sin(angles)])
        points[-1] = points[0]
        yield points * radii + [x, y]


_SHAPES: dict[str, Callable[[Element, Window | None], Iterator[np.ndarray]]] = {
    "line": _line,
    "rect": _rectangle,
    "circle": _ellipse,
    "ellipse": _ellipse,
}


def _path(text: str, scale: float) -> Iterator[np.ndarray]:
    from svgelements import Path

    if len(_NUMBER.findall(text)) > MAX_SKETCH_POINTS:
        raise InputError(f"expected a path of at most {MAX_SKETCH_POINTS} numbers, found more")
    try:
        segments = list(Path(text))
    except Exception:  # the library meets what it does not expect in many ways
        raise InputError(f"expected a path, found {shown(text, 40)!r}") from None
    line: list[np.ndarray] = []
    for segment in segments:
        if type(segment).__name__ == "Move":
            if len(line) > 1:
                yield np.vstack(line)
            line = [_point(segment.end, text)]
            continue
        if not line:
            raise InputError(f"expected a path that begins with a move, found {shown(text, 40)!r}")
        line.append(_piece(segment, scale, text))
    if len(line) > 1:
        yield np.vstack(line)


def _piece(segment: Any, scale: float, text: str) -> np.ndarray:
    """The points (N, 2) of a part of a path without its first."""
    end = _point(segment.end, text) if segment.end is not None else np.zeros((0, 2))
    kind = type(segment).__name__
    if kind in ("Line", "Close") or (kind == "Arc" and not (segment.rx and segment.ry)):
        return end
    if kind == "Arc":
        length = max(segment.rx, segment.ry) * abs(segment.sweep)
    else:
        controls = [segment.start, getattr(segment, "control1", None), getattr(segment, "control2", None)]
        controls += [getattr(segment, "control", None), segment.end]
        places = np.vstack([_point(control, text) for control in controls if control is not None])
        length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    steps = length * scale / _STEP
    count = int(np.clip(np.ceil(steps), _FEWEST, _MOST)) if np.isfinite(steps) else _MOST
    places = np.array(segment.npoint(np.linspace(0, 1, count + 1)[1:]), np.float64)
    places[-1] = end
    return places


def _point(point: Any, text: str) -> np.ndarray:
    place = np.array([[point.x, point.y]], np.float64)
    if not np.isfinite(place).all():
        raise InputError(f"expected a path with finite numbers, found {shown(text, 40)!r}")
    return place
