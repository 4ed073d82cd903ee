"""Which part of its plane a drawing in an SVG shows, and where one that lies in another is put."""

import re
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from caricli.errors import InputError
from caricli.io.sketches.svg_style import length_in_pixels

_SMALLEST = 1e-9
"""Units of the longer side of a drawing, at least."""
_ALIGNED = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}

Box = tuple[float, float, float, float]
"""Left, top, width and height."""


def view_box(root: Element) -> Box | None:
    """Left, top, width and height in the units of the drawing, or None where nothing says them.

    Raises InputError for a drawing too small to be drawn larger.
    """
    box = _box(root)
    if box is None:
        sides: list[Any] = [length_in_pixels(root.get(key)) for key in ("width", "height")]
        box = None if None in sides or not (sides[0] > 0 and sides[1] > 0) else (0.0, 0.0, *sides)
    if box is not None and max(box[2:]) < _SMALLEST:
        size = f"{box[2]:g} x {box[3]:g}"
        raise InputError(f"viewBox: expected a drawing of at least {_SMALLEST:g} units, found one of {size}")
    return box


def frame(
    element: Element, sized: Element, window: tuple[float, float] | None
) -> tuple[np.ndarray, tuple[float, float] | None]:
    """Where a drawing, or a symbol, lies in the one around it.

    element: what has the ``viewBox``. sized: whose width and height count, the same or what uses it. window: size of
    the drawing around, in its units, or None.
    Returns a matrix (2, 3) to the units around, and the size of what it shows, in its own units, or None.
    """
    aside = np.array([length_in_pixels(element.get(key)) or 0.0 for key in ("x", "y")])
    sides = [_side(sized.get(key), window and window[axis]) for axis, key in enumerate(("width", "height"))]
    box = _box(element)
    if box is None or min(box[2:]) < _SMALLEST or not all(sides):
        size = None if None in sides else (sides[0] or 0.0, sides[1] or 0.0)
        return np.column_stack([np.eye(2), aside]), size
    with np.errstate(all="ignore"):  # numbers beyond all bounds are refused where points come of them
        zooms = np.array([sides[0] or 1.0, sides[1] or 1.0]) / box[2:]
        ratio = element.get("preserveAspectRatio") or "xMidYMid"
        if "none" not in ratio:
            zoom = zooms.max() if "slice" in ratio else zooms.min()
            free = (zooms - zoom) * box[2:]
            match = re.search(r"x(Min|Mid|Max)Y(Min|Mid|Max)", ratio)
            aside += free * ([_ALIGNED[word] for word in match.groups()] if match else [0.5, 0.5])
            zooms[:] = zoom
        return np.column_stack([np.diag(zooms), aside - zooms * box[:2]]), (box[2], box[3])


def _side(text: str | None, around: float | None) -> float | None:
    """A width or height; where none is said it is that of what is around, and percents are of this."""
    text = (text or "100%").strip()
    if not text.endswith("%"):
        return length_in_pixels(text) or around
    share = length_in_pixels(text[:-1])
    return around if around is None or share is None else share / 100 * around


def _box(element: Element) -> Box | None:
    """The four numbers of a ``viewBox`` that has a size, or None."""
    words = re.split(r"[\s,]+", (element.get("viewBox") or "").strip())
    numbers: list[Any] = [length_in_pixels(word) for word in words]
    if len(numbers) != 4 or None in numbers or not (numbers[2] > 0 and numbers[3] > 0):
        return None
    return tuple(numbers)
