"""Which part of its plane a drawing in an SVG shows, and where one that lies in another is put."""

import re
from collections.abc import Iterable
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.sketches.svg_style import length_in_pixels

_SMALLEST = 1e-9
"""Units of the longer side of a drawing, at least."""
_ALIGNED = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}

_SIDES = ("width", "height")
_ACROSS = {"left": "0%", "right": "100%"}
_DOWN = {"top": "0%", "bottom": "100%"}
_UPRIGHT = {"y", "y1", "y2", "cy", "ry", "height"}
"""Attributes whose percents are of the height of what is around."""

Box = tuple[float, float, float, float]
"""Left, top, width and height."""

Window = tuple[float, float]
"""Width and height of a drawing, in its own units."""


def view_box(root: Element) -> Box | None:
    """Left, top, width and height in the units of the drawing, or None where nothing says them.

    Raises InputError for a drawing too small to be drawn larger.
    """
    box = _box(root)
    if box is None:
        sides: list[Any] = [length_in_pixels(root.get(key)) for key in _SIDES]
        box = None if None in sides or not (sides[0] > 0 and sides[1] > 0) else (0.0, 0.0, *sides)
    if box is not None and max(box[2:]) < _SMALLEST:
        size = f"{box[2]:g} x {box[3]:g}"
        raise InputError(f"viewBox: expected a drawing of at least {_SMALLEST:g} units, found one of {size}")
    return box


def lengths_of(element: Element, keys: Iterable[str], window: Window | None) -> list[float]:
    """Attributes of an element in units of the drawing that it lies in; 0 where there are none.

    window: that drawing's size. Percents are of its width or height, those of the radius ``r`` of the root mean square
    of both; they are 0 where nothing says it.
    """
    return [_length(element.get(key), window and _around(key, *window)) or 0.0 for key in keys]


def frame(element: Element, sized: Element, window: Window | None) -> tuple[np.ndarray, Window | None]:
    """Where a drawing, or a symbol, lies in the one around it.

    element: what has the ``viewBox``. sized: whose width and height count, the same or what uses it. window: size of
    the drawing around, in its units, or None.
    Returns a matrix (2, 3) to the units around, and the size of what it shows, in its own units, or None.
    """
    aside = np.array(lengths_of(element, ("x", "y"), window))
    sides = [
        _length(sized.get(key), around) or around for key, around in zip(_SIDES, window or (None, None), strict=True)
    ]
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


def origin_of(text: str, window: Window | None) -> np.ndarray:
    """The point (2,) that a ``transform-origin`` names: lengths, percentages of the drawing or its sides, x first, or
    sides in any order.

    window: size of the drawing, in its units, or None. Raises InputError for another.
    """
    words = text.lower().split()[:3]
    if len(words) == 1:
        words = ["50%", *words] if words[0] in _DOWN else [*words, "50%"]
    if len(words) > 1 and (words[0] in _DOWN or words[1] in _ACROSS):
        words[:2] = [words[1], words[0]]
    sides = window or (None, None)
    shares = zip(words, (_ACROSS, _DOWN), sides, strict=False)
    place = [_length(each.get(word, "50%" if word == "center" else word), side) for word, each, side in shares]
    if len(place) != 2 or None in place:
        raise InputError(
            f"transform-origin: expected lengths, or percentages or sides of the drawing, found {shown(text, 40)!r}"
        )
    return np.array(place, np.float64)


def _length(text: str | None, around: float | None) -> float | None:
    """A length, or a percentage of what is around; None where nothing says it."""
    text = (text or "").strip()
    if not text.endswith("%"):
        return length_in_pixels(text)
    share = length_in_pixels(text[:-1])
    return None if around is None or share is None else share / 100 * around


def _around(key: str, width: float, height: float) -> float:
    """What percents of an attribute are of."""
    if key == "r":
        return float(np.hypot(width, height)) / 2**0.5
    return height if key in _UPRIGHT else width


def _box(element: Element) -> Box | None:
    """The four numbers of a ``viewBox`` that has a size, or None."""
    words = re.split(r"[\s,]+", (element.get("viewBox") or "").strip())
    numbers: list[Any] = [length_in_pixels(word) for word in words]
    if len(numbers) != 4 or None in numbers or not (numbers[2] > 0 and numbers[3] > 0):
        return None
    return tuple(numbers)
