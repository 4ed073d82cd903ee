"""Drawing a face (sketch paper, section 3.1, initial sketching): after every stroke the network sees it anew."""

from dataclasses import replace

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.geometry.lines.rows_at import rows_at
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.session.parameters import Parameters, number, only, points
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.structures import Face, Sketch, Stroke

_WIDEST = 64.0
"""Pixels of the canvas, the width of a line."""

_LARGEST = 1000.0
"""Pixels of the canvas, the radius of the eraser."""

_FINEST = 2000
"""Points at most that are put between those of a stroke where it is erased."""


def draw(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """A further stroke.

    points: rows [x, y], pixels of the canvas. pressure: as many from 0 to 1, or none. width: pixels, or none.
    """
    only(parameters, "points", "pressure", "width")
    sketch = work.sketch.with_strokes((*work.sketch.strokes, stroke_of(parameters)))
    return _seen(work, sketch, tools)


def erase(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Rub out what lies under the path of an eraser; a stroke may become two. Where it meets none, nothing changes.

    points: rows [x, y], pixels of the canvas. radius: pixels.
    """
    only(parameters, "points", "radius")
    path = points(parameters, "points")
    radius = number(parameters, "radius", 0.1, _LARGEST)
    strokes = [piece for stroke in work.sketch.strokes for piece in rubbed(stroke, path, radius)]
    if tuple(strokes) == work.sketch.strokes:
        return work
    return _seen(work, work.sketch.with_strokes(strokes), tools)


def clear(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """An empty canvas; where it is empty already, nothing changes."""
    only(parameters)
    return _seen(work, work.sketch.with_strokes(()), tools) if work.sketch.strokes else work


def follow(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """The face whose curves lie on the lines, as ``caricli reconstruct-from-sketch`` makes it.

    share: of the way, 1 where it is not said.
    """
    only(parameters, "share")
    share = number(parameters, "share", 0, 1, 1.0)
    fit = tools.reconstruction.reconstruct(work.sketch, share)
    return replace(work, face=encode_face(fit.face, tools.model), strengths={}, weights={}, remark=fit.describe())


def stroke_of(parameters: Parameters) -> Stroke:
    """The Stroke of parameters. Raises InputError."""
    line = points(parameters, "points")
    width = number(parameters, "width", 0.1, _WIDEST) if "width" in parameters else None
    pressure = None
    if "pressure" in parameters:
        given = parameters["pressure"]
        if not isinstance(given, list) or len(given) != len(line):
            raise InputError(f"pressure: expected {len(line)} numbers, one for every point, found others")
        pressure = points({"pressure": [[each] for each in given]}, "pressure", 1)[:, 0]
    return Stroke(line, pressure=pressure, width=width)


def rubbed(stroke: Stroke, path: np.ndarray, radius: float) -> list[Stroke]:
    """The pieces of a stroke that an eraser leaves; a single point that is left is none.

    path: (N, 2) pixels. radius: pixels.
    """
    fine = _denser(stroke, max(radius, stroke.length / _FINEST))
    left = line_distances(fine.points, [path]) > radius
    if left.all():
        return [stroke]
    ends = np.flatnonzero(np.diff(np.concatenate([[0], left.astype(int), [0]])))
    pieces = []
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        if last - first > 1:
            pressure = None if fine.pressure is None else fine.pressure[first:last]
            pieces.append(replace(fine, points=fine.points[first:last], pressure=pressure))
    return pieces


def _denser(stroke: Stroke, apart: float) -> Stroke:
    """A stroke with points so many pixels apart, or less, between its own that are farther than twice that."""
    lengths = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
    counts = np.where(lengths > 2 * apart, np.ceil(lengths / apart), 1).astype(int)
    at = np.concatenate([*(k + np.arange(count) / count for k, count in enumerate(counts)), [len(counts)]])
    own = np.arange(len(stroke.points))
    points = rows_at(at, own, stroke.points)
    pressure = None if stroke.pressure is None else np.interp(at, own, stroke.pressure)
    return replace(stroke, points=points, pressure=pressure)


def _seen(work: Work, sketch: Sketch, tools: Tools) -> Work:
    """The work with another sketch and the face that the network sees in it; the mean face where nothing is drawn."""
    model = tools.model
    if sketch.strokes:
        seen = see_sketch(sketch, tools.network, tools.basis)
        face = Face(model.template.with_vertices(seen.vertices), seen.camera)
    else:
        face = Face(model.template.with_vertices(model.decode(model.prior.mean)))
    return replace(work, sketch=sketch, face=encode_face(face, model), strengths={}, weights={})


DRAW_OPERATIONS = {"draw": draw, "erase": erase, "clear": clear, "follow": follow}
"""By name."""
