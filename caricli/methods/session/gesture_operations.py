"""Changing a face by strokes on it, from any side (sketch paper, section 3.3)."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from caricli.errors import InputError
from caricli.limits import MAX_CAMERA_SCALE, MIN_CAMERA_SCALE
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.gesture.bulge import bulge
from caricli.methods.gesture.changed import Changed
from caricli.methods.gesture.follow_line import follow_line
from caricli.methods.gesture.selection import Selection, mark_handles, select_region
from caricli.methods.gesture.sight import SeenStroke
from caricli.methods.session.parameters import Parameters, number, only, points, switch
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Camera, Operation
from caricli.structures.gesture import LEVELS, roll_level

UNDO = "undo"
REDO = "redo"

_WHOLE = 0.99
"""Share of the way of which nothing is said."""

_LARGEST = 1000.0
"""Pixels of the view, the radius of the brush."""


def brush(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Brush vertices that are seen into the handles, or out of them.

    points: rows [x, y], pixels of the view. radius: pixels. camera: of the view. erase: whether they are taken out.
    """
    only(parameters, "points", "radius", "camera", "erase")
    radius = number(parameters, "radius", 0.1, _LARGEST)
    erase = switch(parameters, "erase")
    stroke = points(parameters, "points")
    return _selecting(work, mark_handles(work.face, view_of(parameters), stroke, radius, selection_of(work), erase))


def region(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Choose what may move, by a closed stroke. points: rows [x, y], pixels of the view. camera: of the view."""
    only(parameters, "points", "camera")
    stroke = points(parameters, "points")
    return _selecting(work, select_region(work.face, view_of(parameters), stroke, selection_of(work)))


def deselect(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Neither handles nor a region."""
    only(parameters)
    return _selecting(work, Selection())


def line(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Move the handles, or where there are none the outline, to a line.

    points: rows [x, y], pixels of the view. camera: of the view. symmetric: whether the other side does the same.
    """
    only(parameters, "points", "camera", "symmetric")
    stroke = SeenStroke(points(parameters, "points"), view_of(parameters))
    symmetric = switch(parameters, "symmetric")
    return _changed(work, follow_line(work.face, tools.model.template, stroke, selection_of(work), symmetric), tools)


def raise_region(work: Work, parameters: Parameters, tools: Tools, sign: int = 1) -> Work:
    """Bulge the region or the handles, or with the sign -1 press them in.

    level: 1, 2 or 3. symmetric: whether the other side does the same.
    """
    only(parameters, "level", "symmetric")
    level = number(parameters, "level", 1, LEVELS)
    if level != int(level):
        raise InputError(f"level: expected 1, 2 or 3, found {level:g}")
    symmetric = switch(parameters, "symmetric")
    return _changed(
        work, bulge(work.face, tools.model.template, selection_of(work), sign * int(level), symmetric), tools
    )


def gesture(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """What the network takes a stroke for. points, camera, symmetric: as of ``line``. Raises InputError for arrows."""
    meant = meaning_of(Operation("gesture", parameters), tools)
    if isinstance(meant, str):
        raise InputError(f"expected a stroke that changes the face, found {meant}")
    return GESTURE_OPERATIONS[meant.name](work, meant.parameters, tools)


def meaning_of(operation: Operation, tools: Tools) -> Operation | str:
    """The operation that a stroke stands for, or UNDO or REDO. Raises InputError where it is doubtful.

    operation: Operation with the parameters of ``gesture``.
    """
    parameters = operation.parameters
    only(parameters, "points", "camera", "symmetric")
    recognised = tools.gestures.recognise(points(parameters, "points"))
    if recognised.name is None:
        name = recognised.likeliest.replace("up_roll", "bulge").replace("down_roll", "press in").replace("_", " ")
        share = f"{100 * recognised.probability:.0f} %"
        raise InputError(f"expected a gesture, found a stroke that may be anything (rather {name}, {share})")
    if recognised.name.endswith("_arrow"):
        return UNDO if recognised.name.startswith("left") else REDO
    symmetric = {"symmetric": True} if switch(parameters, "symmetric") else {}
    level = roll_level(recognised.name)
    if level:
        return Operation("bulge" if level > 0 else "depress", {"level": abs(level), **symmetric})
    drawn = {name: parameters[name] for name in ("points", "camera") if name in parameters}
    return Operation(recognised.name, drawn | (symmetric if recognised.name == "line" else {}))


def view_of(parameters: Parameters) -> Camera:
    """The Camera of a view: an object of scale, rotation (three rows) and translation. Raises InputError."""
    given = parameters.get("camera")
    if not isinstance(given, dict):
        raise InputError("camera: expected an object with scale, rotation and translation, found none")
    only(given, "scale", "rotation", "translation")
    scale = number(given, "scale", MIN_CAMERA_SCALE, MAX_CAMERA_SCALE)
    rotation = points(given, "rotation", 3)
    place = points({"translation": [given.get("translation")]}, "translation")
    return Camera(scale, rotation, place[0])


def selection_of(work: Work) -> Selection:
    """The handles and the region of a work."""
    chosen = np.zeros(0, np.int64) if work.region is None else work.region
    return Selection(work.handles, chosen, work.skin)


def _selecting(work: Work, selection: Selection) -> Work:
    chosen = selection.region if len(selection.region) else None
    return replace(work, handles=selection.handles, region=chosen, skin=selection.skin)


def _changed(work: Work, changed: Changed, tools: Tools) -> Work:
    part = f"{100 * changed.share:.0f} % of the way: farther would turn triangles over"
    remark = part if changed.share < _WHOLE else ""
    return replace(work, face=encode_face(changed.face, tools.model), remark=remark)


GESTURE_OPERATIONS: dict[str, Callable[[Work, Parameters, Tools], Work]] = {
    "brush": brush,
    "region": region,
    "deselect": deselect,
    "line": line,
    "bulge": raise_region,
    "depress": partial(raise_region, sign=-1),
    "gesture": gesture,
}
"""By name."""
