"""Sketches as SVG."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import read_bytes, text_start
from caricli.io.outputs import write_bytes
from caricli.io.parse_number import parse_number
from caricli.io.parse_xml import parse_xml
from caricli.io.sketches.svg_brush import Brush
from caricli.io.sketches.svg_clip import Clipper, Shape
from caricli.io.sketches.svg_path import outline_points
from caricli.io.sketches.svg_style import WHITE, Paper, Style, style_rules
from caricli.io.sketches.svg_view import Window, frame, lengths_of, origin_of, view_box
from caricli.limits import MAX_COORDINATE, MAX_SKETCH_POINTS, MAX_SKETCH_SIDE, MAX_SVG_BYTES
from caricli.structures.sketch import CANVAS, CURVES, Sketch, Stroke, StrokeKind

KIND = "an SVG of lines"
_ADVICE = "; Illustrator leaves them out where its editing capabilities are not preserved"
_MAX_DEPTH = 64
_MAX_ELEMENTS = 50_000
_LARGEST = 4096.0
"""Pixels of the longer side of a canvas, at most; smaller ones than CANVAS become as large."""

_GROUPS = {"svg", "g", "a", "switch", "symbol"}
_LINES = {"path", "line", "polyline", "polygon", "rect", "circle", "ellipse"}
_URL = re.compile(r"\s*url\(\s*[\"']?#([^\"')]+)[\"']?\s*\)\s*")
_WORD = re.compile(r"[^\W\d_]+(?:_[^\W\d_]+)*")
_ATTRIBUTES = ("id", "class", "{http://www.inkscape.org/namespaces/inkscape}label", "data-name")
"""Where a drawing program puts the name that somebody gave to a layer or a line."""
_NOSE = "nose"
"""The curve below it, and what a layer of all its lines is called: these are features, and find their curves."""


@dataclass(frozen=True)
class _Place:
    """What an element inherits: a matrix (2, 3) to the canvas, the size of the drawing that it lies in, in units of it,
    or None, style, kind and curve, what all lines are cut to the inside of, and how deep it lies."""

    matrix: np.ndarray
    window: Window | None
    style: Style = Style()
    kind: StrokeKind | None = None
    curve: str | None = None
    clips: tuple[Sequence[Shape], ...] = ()
    depth: int = 0

    def framed(self, element: Element, size: Element) -> "_Place":
        """In a drawing or a symbol that lies in this place, as wide and high as an element says."""
        own, window = frame(element, size, self.window)
        return replace(self, matrix=_composed(self.matrix, own), window=window)


def is_svg(start: bytes) -> bool:
    """Whether a file that begins so is an SVG."""
    return text_start(start).startswith(b"<") and b"<svg" in start


def read_svg(path: str | Path) -> Sketch:
    """Read a sketch from an SVG: its paths, lines and shapes with their transforms, in groups and where they are used.

    A class, an id or a layer's name that is a kind (silhouette, feature, wrinkle) or a curve of ``CURVES`` says what a
    stroke, or all in a group, is. What is filled, long and thin is what a brush drew: the line in its middle counts.
    Where there is any line, what else is only filled is left out: it is a background, and one that covers the canvas is
    the paper, else white, on which a stroke of its colour is no line. What lies beside the canvas altogether is left
    out, and lines are cut to the shapes of a ``clip-path``; one in units of an object's box is passed over.
    Raises InputError when it is no SVG, is damaged or too large, or holds scripts, entities or references to elsewhere.
    """
    data = read_bytes(path, MAX_SVG_BYTES, KIND)
    with naming(path):
        root = parse_xml(data, KIND, _ADVICE)
        if _name(root) != "svg":
            raise InputError(f"expected {KIND}, found <{shown(_name(root), 40)}>")
        return _Reader(root).sketch()


def write_svg(path: str | Path, sketch: Sketch) -> None:
    """Write a sketch as SVG: a polyline for every stroke, its kind and curve as classes.

    Raises OutputError when the file cannot be written.
    """
    width, height = sketch.size
    # In an SVG the corner of the first pixel, not its centre, is the origin.
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="-0.5 -0.5 {width} {height}">',
        '<g fill="none" stroke="black" stroke-width="1.4" stroke-linecap="round" stroke-linejoin="round">',
        *map(_polyline, sketch.strokes),
        "</g>",
        "</svg>",
    ]
    write_bytes(path, ("\n".join(lines) + "\n").encode())


def _polyline(stroke: Stroke) -> str:
    from xml.sax.saxutils import quoteattr

    words = [f'class="{stroke.kind}"']
    if stroke.curve is not None:
        words.append(f"data-curve={quoteattr(stroke.curve)}")
    if stroke.width is not None:
        words.append(f'stroke-width="{stroke.width:.9g}"')
    if stroke.pressure is not None:
        words.append(f'data-pressure="{" ".join(f"{x:.4g}" for x in stroke.pressure)}"')
    places = " ".join(f"{round(x, 4):.12g},{round(y, 4):.12g}" for x, y in stroke.points.tolist())
    return f'<polyline {" ".join(words)} points="{places}"/>'


def _name(element: Element) -> str:
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


class _Reader:
    """Walks through the elements of an SVG."""

    def __init__(self, root: Element) -> None:
        self.root = root
        elements = list(root.iter())
        if len(elements) > _MAX_ELEMENTS:
            raise InputError(f"expected at most {_MAX_ELEMENTS} elements, found {len(elements)}")
        for element in elements:
            if _name(element) == "script":
                raise InputError(f"expected {KIND}, found a script")
            if _name(element) in ("use", "image"):
                _target(element)
        sheets = [element.text or "" for element in elements if _name(element) == "style"]
        self.rules = style_rules("".join(sheets))
        # Of several of one id the first counts.
        self.by_id = {key: element for element in reversed(elements) if (key := element.get("id"))}
        self.visits = 0
        self.points = 0
        self.brush = Brush()
        self.clipper = Clipper()
        self.clips: dict[tuple[str, bytes], list[Shape]] = {}
        self.size: tuple[int, int] | None = None
        self.paper: Paper = WHITE

    def sketch(self) -> Sketch:
        """The sketch of all visible lines."""
        box = view_box(self.root)
        matrix = np.array([[1.0, 0, 0], [0, 1, 0]])
        if box is not None:
            self.size, matrix = _canvas(*box)
        strokes = self._drawn(_Place(matrix, None if box is None else (box[2], box[3])))
        if not strokes and any(_name(element) == "image" for element in self.root.iter()):
            raise InputError(f"expected {KIND}, found a picture alone: give it as PNG or JPEG")
        if self.size is None:
            size, matrix = _canvas(*_box_around(strokes))
            return Sketch(tuple(self._drawn(_Place(matrix, None))), size)
        # Where all of it lies beside the canvas, who reads it is to be told so.
        seen = [stroke for stroke in strokes if _meets(stroke, self.size)] or strokes
        return Sketch(tuple(seen), self.size)

    def _drawn(self, place: _Place) -> list[Stroke]:
        """Strokes of all of the drawing in a place: what has lines, or where nothing has, what is filled."""
        self.visits = self.points = 0
        self.brush = Brush()
        self.clipper = Clipper()
        drawn = list(self._walk(self.root, place))
        return [stroke for stroke, has_stroke in drawn if has_stroke] or [stroke for stroke, _ in drawn]

    def _walk(self, element: Element, place: _Place) -> Iterator[tuple[Stroke, bool]]:
        self.visits += 1
        if self.visits > _MAX_ELEMENTS or place.depth > _MAX_DEPTH:
            raise InputError(f"expected at most {_MAX_ELEMENTS} elements, {_MAX_DEPTH} deep, found more")
        name = _name(element)
        if name not in _GROUPS | _LINES | {"use"}:
            return
        style = place.style.within(element, self.rules)
        if style.hidden:
            return
        matrix = _within(place, style)
        inner = _Place(matrix, place.window, style, *_meaning(element, place), place.clips, place.depth + 1)
        if style.clip:
            inner = replace(inner, clips=(*place.clips, *self._clips(_URL.sub(r"\1", style.clip), inner)))
        if name == "svg" and element is not self.root:
            inner = inner.framed(element, element)
        if name == "use":
            target = self.by_id.get(_target(element))
            if target is not None:
                yield from self._used(target, element, inner)
        elif name in _LINES:
            if style.visible:
                yield from self._lines(element, inner)
        else:
            for child in element:
                # What a symbol holds is drawn only where it is used.
                if _name(child) != "symbol":
                    yield from self._walk(child, inner)

    def _used(self, target: Element, use: Element, place: _Place) -> Iterator[tuple[Stroke, bool]]:
        """What is drawn where something is used. place: of the use."""
        aside = np.column_stack([np.eye(2), lengths_of(use, ("x", "y"), place.window)])
        place = replace(place, matrix=_composed(place.matrix, aside))
        yield from self._walk(target, place.framed(target, use) if _name(target) == "symbol" else place)

    def _lines(self, element: Element, place: _Place) -> Iterator[tuple[Stroke, bool]]:
        lines, scale = self._shape(element, place)
        style = place.style
        stroked = style.stroked(self.paper)
        marks = self.brush.lines(lines, style.even_odd) if style.inked(self.paper) and not stroked else []
        strokes = [
            Stroke(mark.points, place.kind or StrokeKind.UNKNOWN, place.curve, width=_bounded(mark.width))
            for mark in marks
        ]
        if not strokes and not style.unseen(self.paper):
            strokes = [_stroke(element, line, place, scale) for line in lines]
        for stroke in strokes:
            parts = [stroke.points]
            for clip in place.clips:
                parts = [part for each in parts for part in self.clipper.cut(each, clip)]
            for part in parts:
                yield stroke if part is stroke.points else stroke.moved_to(part), bool(marks) or stroked
        if self.size is not None and len(lines) == 1 and _covers(lines[0], self.size):
            self.paper = style.covered(self.paper)

    def _clips(self, key: str, place: _Place) -> list[list[Shape]]:
        """The clipPath of an id, which is none where it is of no such element, or in units of an object's box. place:
        of the element that it clips."""
        clip = self.by_id.get(key)
        if clip is None or _name(clip) != "clipPath" or clip.get("clipPathUnits") == "objectBoundingBox":
            return []
        there = (key, place.matrix.tobytes())
        if there not in self.clips:
            style = Style().within(clip, self.rules)
            inner = replace(place, matrix=_within(place, style), style=style)
            self.clips[there] = list(self._clip(clip, inner))
        return [self.clips[there]]

    def _clip(self, clip: Element, place: _Place) -> Iterator[Shape]:
        """The shapes of a clipPath. place: of what is in it."""
        for child in clip:
            style = place.style.within(child, self.rules)
            inner = replace(place, matrix=_within(place, style))
            if _name(child) == "use":
                aside = np.column_stack([np.eye(2), lengths_of(child, ("x", "y"), place.window)])
                child = self.by_id.get(_target(child), child)
                inner = replace(inner, matrix=_composed(inner.matrix, aside))
                inner = replace(inner, matrix=_within(inner, style.within(child, self.rules)))
            if _name(child) in _LINES - {"line"}:
                yield self._shape(child, inner)[0], style.clip_even_odd

    def _shape(self, element: Element, place: _Place) -> tuple[list[np.ndarray], float]:
        """Lines (N, 2) of a shape, pixels of the canvas, and pixels of a unit."""
        with np.errstate(all="ignore"):
            scale = float(np.sqrt(abs(np.linalg.det(place.matrix[:, :2]))))
            return list(self._outlines(element, place, scale)), scale

    def _outlines(self, element: Element, place: _Place, scale: float) -> Iterator[np.ndarray]:
        """Lines (N, 2) of a shape, pixels of the canvas."""
        for line in outline_points(element, _name(element), scale, place.window):
            self.points += len(line)
            if self.points > MAX_SKETCH_POINTS:
                raise InputError(f"expected at most {MAX_SKETCH_POINTS} points, found more")
            points = line @ place.matrix[:, :2].T + place.matrix[:, 2]
            if not (np.abs(points) <= MAX_COORDINATE).all():
                raise InputError(f"expected finite coordinates of at most {MAX_COORDINATE:g}, found others")
            yield points


def _stroke(element: Element, points: np.ndarray, place: _Place, scale: float) -> Stroke:
    width = place.style.width
    width = None if width is None or not 0 < width * scale < MAX_SKETCH_SIDE else width * scale
    pressure = None
    text = element.get("data-pressure")
    if text is not None:
        try:
            pressure = np.array([parse_number(word) for word in text.split()])
        except ValueError:
            raise InputError("data-pressure: expected numbers, found others") from None
    return Stroke(points, place.kind or StrokeKind.UNKNOWN, place.curve, pressure, width)


def _meaning(element: Element, place: _Place) -> tuple[StrokeKind | None, str | None]:
    """Kind and curve that an element says it has, else those around it."""
    kind = None
    curve = element.get("data-curve")
    words = [(key, word) for key in _ATTRIBUTES for word in (element.get(key) or "").split()]
    for key, word in words:
        plain = "_".join(_WORD.findall(word.replace("_x5F_", "_").lower().replace("-", "_")))
        if plain in set(StrokeKind):
            kind = kind or StrokeKind(plain)
        # The silhouette is a kind and a curve: a class may be of its parts, an id is of one line.
        if plain in CURVES and (plain not in set(StrokeKind) or (key != "class" and _name(element) in _LINES)):
            curve = curve or plain
    if kind is None and curve in CURVES:
        kind = CURVES[curve]
    if curve == _NOSE and _name(element) in _GROUPS and sum(_name(each) in _LINES for each in element.iter()) > 1:
        curve = None
    return kind or place.kind, curve or place.curve


def _target(element: Element) -> str:
    """The id that a use or an image refers to. Raises InputError when it lies elsewhere."""
    href = element.get("href") or element.get("{http://www.w3.org/1999/xlink}href") or ""
    inside = href.startswith("#") or (_name(element) == "image" and href.startswith("data:"))
    if href and not inside:
        raise InputError(f"expected {KIND} and nothing outside the file, found a reference to {shown(href, 40)!r}")
    return href[1:]


def _within(place: _Place, style: Style) -> np.ndarray:
    """The matrix (2, 3) of an element of a style with a transform, in a place."""
    transform = style.transform
    if not transform or transform == "none":
        return place.matrix
    from svgelements import Matrix

    try:
        own = Matrix(transform[:4096])
        values = np.array([[own.a, own.c, own.e], [own.b, own.d, own.f]], np.float64)
    except Exception:  # the library meets what it does not expect in many ways
        values = np.full((2, 3), np.nan)
    if not np.isfinite(values).all():
        raise InputError(f"transform: expected one with finite numbers, found {shown(transform, 40)!r}")
    if style.origin:
        origin = origin_of(style.origin, place.window)
        values[:, 2] += origin - values[:, :2] @ origin
    return _composed(place.matrix, values)


def _composed(matrix: np.ndarray, own: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.column_stack([matrix[:, :2] @ own[:, :2], matrix[:, :2] @ own[:, 2] + matrix[:, 2]])


def _meets(stroke: Stroke, size: tuple[int, int]) -> bool:
    """Whether the box of a stroke meets the canvas of a size."""
    return bool((stroke.points.max(0) >= -0.5).all() and (stroke.points.min(0) <= np.array(size) - 0.5).all())


def _covers(line: np.ndarray, size: tuple[int, int]) -> bool:
    """Whether an outline (N, 2) is an upright rectangle over the whole canvas of a size, but for a hundredth."""
    rest = 0.01 * max(size)
    upright = len(line) == 5 and (np.diff(line, axis=0) == 0).any(axis=1).all()
    return bool(upright and (line.min(0) <= rest).all() and (line.max(0) >= np.array(size) - rest).all())


def _bounded(width: float) -> float:
    return float(np.clip(width, 1e-3, MAX_SKETCH_SIDE))


def _canvas(left: float, top: float, width: float, height: float) -> tuple[tuple[int, int], np.ndarray]:
    """Size in pixels and the matrix to them of a drawing's own units."""
    longer = max(width, height)
    zoom = float(np.clip(longer, CANVAS, _LARGEST)) / longer
    size = (max(round(width * zoom), 1), max(round(height * zoom), 1))
    return size, np.array([[zoom, 0, -left * zoom - 0.5], [0, zoom, -top * zoom - 0.5]])


def _box_around(strokes: list[Stroke]) -> tuple[float, float, float, float]:
    """Left, top, width and height of what is around strokes, with a margin; the usual canvas where there are none."""
    if not strokes:
        return 0.0, 0.0, CANVAS, CANVAS
    points = np.concatenate([stroke.points for stroke in strokes])
    extent = np.maximum(np.ptp(points, axis=0), 1e-3)
    margin = 0.05 * extent.max()
    left, top = points.min(0) - margin
    width, height = extent + 2 * margin
    return float(left), float(top), float(width), float(height)
