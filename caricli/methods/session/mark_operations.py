"""Placing landmarks on a picture, and the face that they are of."""

from dataclasses import replace
from typing import Any

from caricli.errors import InputError, shown
from caricli.io.landmarks import landmarks_from_json
from caricli.methods.marks.move_marks import FACE, GroupMove, move_group, move_point, switch_off
from caricli.methods.session.parameters import Parameters, choice, number, only, points, switch
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Landmarks
from caricli.structures.landmarks import GROUPS
from caricli.template.template import Template

_LARGEST = 100.0
"""Factor of a group's size, and one over it the smallest."""


def marks(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """All landmarks at once, as a detector or a file has them, or the mean shape.

    landmarks: an object of the schema caricli.landmarks/1; of the picture, where there is one, and of its size.
    """
    only(parameters, "landmarks")
    given = landmarks_from_json(parameters.get("landmarks"))
    if work.picture is not None:
        height, width = work.picture.shape[:2]
        if given.image_size not in (None, (width, height)):
            other = "{} x {}".format(*given.image_size)
            raise InputError(f"expected landmarks of the {width} x {height} picture, found {other}")
        given = replace(given, image_size=(width, height))
    return replace(work, landmarks=given)


def mark(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Put a point somewhere. point: its number. place: [x, y] pixels. symmetric: whether its partner does the same."""
    only(parameters, "point", "place", "symmetric")
    placed = placed_marks(work)
    x, y = points({"place": [parameters.get("place")]}, "place")[0]
    point = _point(parameters.get("point"))
    return replace(work, landmarks=move_point(placed, point, (x, y), _side(parameters, tools)))


def mark_group(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Move points together about their centre.

    group: "face", or a name of GROUPS. shift: [x, y] pixels. turn: degrees, clockwise. scale: of its size. symmetric:
    whether the group of the other side does the same.
    """
    only(parameters, "group", "shift", "turn", "scale", "symmetric")
    placed = placed_marks(work)
    group = choice(parameters, "group", (FACE, *GROUPS))
    x, y = points({"shift": [parameters.get("shift", [0, 0])]}, "shift")[0]
    turn = number(parameters, "turn", -360, 360, 0.0)
    move = GroupMove((x, y), turn, number(parameters, "scale", 1 / _LARGEST, _LARGEST, 1.0))
    return replace(work, landmarks=move_group(placed, group, move, _side(parameters, tools)))


def mark_off(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Points that are not known. points: their numbers."""
    only(parameters, "points")
    placed = placed_marks(work)
    given = parameters.get("points")
    if not isinstance(given, list):
        raise InputError(f"points: expected a list of numbers, found {shown(repr(given), 60)}")
    return replace(work, landmarks=switch_off(placed, [_point(value) for value in given]))


def mark_face(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """The face that the landmarks are of, as ``caricli reconstruct-from-landmarks`` makes it of them alone."""
    only(parameters)
    placed = placed_marks(work)
    face, _ = tools.encoder.encode(placed.head_points, placed.spreads)
    return replace(work, face=face, strengths={}, weights={})


def placed_marks(work: Work) -> Landmarks:
    """The landmarks of a work. Raises InputError where there are none."""
    if work.landmarks is None:
        raise InputError("expected landmarks first, found none; Find the face or Mean shape lays some")
    return work.landmarks


def _point(value: Any) -> int:
    """The number of a point. Raises InputError for what is none."""
    if type(value) is not int:
        raise InputError(f"point: expected a number, found {shown(repr(value), 60)}")
    return value


def _side(parameters: Parameters, tools: Tools) -> Template | None:
    """The template that tells where the other side is, where it is to move along."""
    return tools.model.template if switch(parameters, "symmetric") else None


MARK_OPERATIONS = {
    "marks": marks,
    "mark": mark,
    "mark_group": mark_group,
    "mark_off": mark_off,
    "mark_face": mark_face,
}
"""By name."""
