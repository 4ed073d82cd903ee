"""Redrawing the lines of a face (sketch paper, section 3.2, follow-up sketching): the face follows exactly."""

from dataclasses import replace

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.match_line import resample
from caricli.methods.faces.encode_face import EncodedFace, encode_face
from caricli.methods.session.draw_operations import stroke_of
from caricli.methods.session.parameters import Parameters, number, only, points
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import CANVAS_SIDE, Gap, Work
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_curves
from caricli.structures import Camera, Stroke, StrokeKind

_FILL = 0.7
"""Of the canvas: the longer side of the mean head, so that larger ones have room."""

_REACH = 24.0
"""Pixels of the canvas, the farthest that an eraser is from the line that is meant."""

_SHORTEST = 3.0
"""Pixels of the canvas: what is shorter is a dot."""

_SEGMENTS = 3
"""Pieces of a line, one of which is erased at a time; silhouettes have none."""

_PARTNERS = (("eye_upper_", "eye_lower_"), ("mouth_upper", "mouth_lower"), ("mouth_inner_upper", "mouth_inner_lower"))
"""Beginnings of the names of contours that meet at their ends."""


def redraw_camera(tools: Tools) -> Camera:
    """The camera of the mode: from the front, the same for all faces."""
    template = tools.model.template
    mean = tools.model.decode(tools.model.prior.mean)
    return canvas_camera(template.with_vertices(mean).vertices, tools.reconstruction.handles.curves, (0.0, 0.0),
                         CANVAS_SIDE, _FILL)  # fmt: skip


def face_lines(work: Work, tools: Tools) -> dict[str, Stroke]:
    """The lines of the face by the names of their curves, a point for every vertex."""
    strokes = draw_curves(work.face.vertices, tools.reconstruction.handles.curves, redraw_camera(tools))
    return {str(stroke.curve): stroke for stroke in strokes}


def shown_lines(work: Work, tools: Tools) -> list[Stroke]:
    """The lines of the face without what is erased, and the wrinkles."""
    shown = []
    for name, stroke in face_lines(work, tools).items():
        if work.gap is None or work.gap.curve != name:
            shown.append(stroke)
            continue
        for piece in _left(stroke.points, work.gap):
            if len(piece) > 1:
                shown.append(stroke.moved_to(piece))
    return [*shown, *work.wrinkles]


def cut(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Erase a segment of a feature's line, or the part of the silhouette along a path.

    Where a part of the same line is erased already, all between the two goes, too. points: path of the eraser, rows
    [x, y] in pixels of the canvas. radius: pixels, not looked at. Raises InputError where no line is near, or where
    another line has a gap still.
    """
    only(parameters, "points", "radius")
    path = points(parameters, "points")
    number(parameters, "radius", 0, 1000, 0)
    lines = face_lines(work, tools)
    gaps = {name: _gaps(path, stroke.points) for name, stroke in lines.items()}
    name = min(gaps, key=lambda each: float(gaps[each].min(1).mean()))
    if gaps[name].min() > _REACH:
        raise InputError("expected a path over a line of the face, found none there")
    if work.gap is not None and work.gap.curve != name:
        raise InputError(f"expected a stroke for the gap in {_words(work.gap.curve)} first")
    line = lines[name]
    first, last = _part(gaps[name], line)
    if work.gap is not None:
        first, last = _joined((first, last), work.gap, line)
    if line.closed and last - first > len(line.points) - 3:
        raise InputError("expected a path that leaves something of the silhouette, found all of it erased")
    return replace(work, gap=Gap(name, first, last))


def mend(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """A stroke: it fills the gap, and the face follows; where nothing is erased it is a wrinkle.

    The stroke is snapped to the open ends. Where it gives a contour of eye or mouth other ends, the other contour goes
    along. points, pressure, width: as of ``draw``.
    """
    only(parameters, "points", "pressure", "width")
    stroke = stroke_of(parameters)
    if stroke.length < _SHORTEST:
        raise InputError("expected a line, found a dot")
    if work.gap is None:
        return replace(work, wrinkles=(*work.wrinkles, replace(stroke, kind=StrokeKind.WRINKLE)))
    lines = {name: each.points for name, each in face_lines(work, tools).items()}
    old = lines[work.gap.curve]
    new = _filled(old, work.gap, stroke.points)
    moved = {work.gap.curve: new}
    partner = _partner(work.gap.curve, lines)
    if partner is not None:
        moved[partner] = _along(lines[partner], old[[0, -1]], new[[0, -1]])
    return replace(work, face=_followed(work, {**lines, **moved}, tools), gap=None, strengths={})


def _gaps(path: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(P, N) pixels between points of a path and of a line."""
    return np.linalg.norm(path[:, None] - line[None], axis=2)


def _part(gaps: np.ndarray, line: Stroke) -> tuple[int, int]:
    """First and last point that go. gaps: (P, N) of the path from the line."""
    count = gaps.shape[1]
    near = gaps.argmin(1)
    if line.kind == StrokeKind.SILHOUETTE:
        if not line.closed:
            return max(int(near.min()) - 1, 0), min(int(near.max()) + 1, count - 1)
        round_trip = count - 1
        steps = (np.diff(near) + round_trip // 2) % round_trip - round_trip // 2
        along = near[0] + np.append(0, np.cumsum(steps))
        first = int(along.min()) - 1
        return first % round_trip, int(along.max()) + 1 + first % round_trip - first
    bounds = np.linspace(0, count - 1, _SEGMENTS + 1).round().astype(int)
    segment = int(np.clip(np.searchsorted(bounds, np.median(near), side="right") - 1, 0, _SEGMENTS - 1))
    return int(bounds[segment]), int(bounds[segment + 1])


def _joined(part: tuple[int, int], gap: Gap, line: Stroke) -> tuple[int, int]:
    """A part together with a gap of the same line, and what lies between them."""
    rounds = (-1, 0, 1) if line.closed else (0,)
    size = len(line.points) - 1
    wholes = [(min(part[0] + n * size, gap.first), max(part[1] + n * size, gap.last)) for n in rounds]
    first, last = min(wholes, key=lambda each: each[1] - each[0])
    return (first % size, last + first % size - first) if line.closed else (first, last)


def _closed(line: np.ndarray) -> bool:
    return bool((line[0] == line[-1]).all())


def _rolled(line: np.ndarray, first: int) -> np.ndarray:
    """A closed line (N, 2) that begins at another point."""
    ring = np.roll(line[:-1], -first, axis=0)
    return np.append(ring, ring[:1], axis=0)


def _left(line: np.ndarray, gap: Gap) -> list[np.ndarray]:
    """What a gap leaves of a line (N, 2)."""
    if _closed(line):
        return [_rolled(line, gap.first)[gap.last - gap.first :]]
    return [line[: gap.first + 1], line[gap.last :]]


def _filled(line: np.ndarray, gap: Gap, stroke: np.ndarray) -> np.ndarray:
    """A line (N, 2) whose gap is filled by a stroke (M, 2), drawn in either direction, snapped to the open ends."""
    if _closed(line):
        size = gap.last - gap.first
        filled = _rolled(line, gap.first)
        filled[: size + 1] = _snapped(filled[[0, size]], (True, True), stroke, size + 1)
        return _rolled(np.append(filled[:-1], filled[:1], axis=0), len(line) - 1 - gap.first)
    inner = (gap.first > 0, gap.last < len(line) - 1)
    filled = line.copy()
    piece = _snapped(line[[gap.first, gap.last]], inner, stroke, gap.last - gap.first + 1)
    filled[gap.first : gap.last + 1] = piece
    return filled


def _snapped(ends: np.ndarray, inner: tuple[bool, bool], stroke: np.ndarray, count: int) -> np.ndarray:
    """Points (count, 2) of a stroke, its ends moved onto those (2, 2) of a gap that are inside a line."""
    straight = np.linalg.norm(stroke[[0, -1]] - ends, axis=1).sum()
    turned = np.linalg.norm(stroke[[-1, 0]] - ends, axis=1).sum()
    piece = resample(stroke if straight <= turned else stroke[::-1], count)
    missing = (ends - piece[[0, -1]]) * np.array(inner)[:, None]
    share = np.linspace(0, 1, count)[:, None]
    return piece + (1 - share) * missing[0] + share * missing[1]


def _partner(name: str, lines: dict[str, np.ndarray]) -> str | None:
    """The contour that meets another one at its ends, or None."""
    for one, other in _PARTNERS:
        for own, its in ((one, other), (other, one)):
            if name.startswith(own) and name.replace(own, its, 1) in lines:
                return name.replace(own, its, 1)
    return None


def _along(line: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """A line (N, 2) turned, scaled and moved as its ends are, from before (2, 2) to after (2, 2)."""
    old, new = ([complex(*end) for end in ends] for ends in (before, after))
    factor = (new[1] - new[0]) / (old[1] - old[0])
    moved = new[0] + factor * (line[:, 0] + 1j * line[:, 1] - old[0])
    return np.stack([moved.real, moved.imag], axis=1)


def _followed(work: Work, lines: dict[str, np.ndarray], tools: Tools) -> EncodedFace:
    """The face with its curves on lines, by their names."""
    reconstruction = tools.reconstruction
    handles = reconstruction.handles
    sums = np.zeros((len(handles.vertices), 2))
    counts = np.zeros(len(handles.vertices))
    own = {name: stroke.points for name, stroke in face_lines(work, tools).items()}
    for name, rows in handles.rows.items():
        # Where contours share a vertex, what moved counts.
        weights = np.linalg.norm(lines[name] - own[name], axis=1) + 1e-6
        np.add.at(sums, rows, weights[:, None] * lines[name])
        np.add.at(counts, rows, weights)
    template = tools.model.template
    moved = reconstruction.follower.follow(work.face.vertices, redraw_camera(tools), sums / counts[:, None])
    return encode_face(work.face.with_vertices(template.mended(moved)), tools.model)


def _words(name: str) -> str:
    return name.replace("_", " ")


REDRAW_OPERATIONS = {"cut": cut, "mend": mend}
"""By name."""
