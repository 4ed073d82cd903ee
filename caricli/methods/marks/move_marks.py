"""Landmarks moved by hand: one by one, in groups, with their partners on the other side of the face."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.errors import InputError
from caricli.methods.marks.mirror_map import mirror_map
from caricli.structures import Landmarks
from caricli.structures.detection import turn_axes
from caricli.structures.landmarks import GROUPS, MIRRORED
from caricli.template.template import Template

BY_HAND = 5e-4
"""Of the landmarks' diagonal: spread of a point that a hand has placed, where points have spreads; well below
``IntrinsicSettings.exact``, so that the surface goes where it is."""

FACE = "face"
"""Name of the group of all points."""


@dataclass(frozen=True)
class GroupMove:
    """How a group of points moves about its own centre.

    shift: pixels. turn: degrees, clockwise as the picture is seen. scale: factor of its size, above zero.
    """

    shift: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0
    scale: float = 1.0


def move_point(
    marks: Landmarks, number: int, place: tuple[float, float], symmetric_on: Template | None = None
) -> Landmarks:
    """Put a point somewhere, and the head's own there, too; one that was switched off is known from then on.

    marks: Landmarks. number: of the point. place: pixels. symmetric_on: the Template whose landmarks tell how the face
    is turned, where the partner on the other side is to make the mirrored move (``mirror_map``), or None. Points on the
    axis of the face have no partner, and what is not known makes no move.
    Raises InputError for no such point and for a place far outside the picture, NumericsError where the points tell no
    pose.
    """
    _check_numbers(marks, [number])
    points = marks.points.copy()
    partner = MIRRORED[number]
    moved = [number]
    if symmetric_on is not None and partner != number and marks.known[[number, partner]].all():
        points[partner] += mirror_map(marks.points, symmetric_on) @ (np.array(place) - points[number])
        moved.append(partner)
    points[number] = place
    return _placed(marks, points, moved, _changed(marks.slides, [number], 0.0))


def move_group(marks: Landmarks, group: str, move: GroupMove, symmetric_on: Template | None = None) -> Landmarks:
    """Shift, turn and scale the known points of a group about their centre.

    marks: Landmarks. group: of GROUPS, or FACE for all. move: GroupMove. symmetric_on: as in ``move_point``; a group
    that has both sides of the face, as the mouth, has no partner. Both sides turn and grow about the centre of those
    points that are known on both.
    Raises InputError for an unknown group, one without known points and a scale of zero or less.
    """
    numbers = group_points(marks, group)
    if not 0 < move.scale < np.inf:
        raise InputError(f"scale: expected more than 0, found {move.scale:g}")
    linear = move.scale * turn_axes(np.radians(move.turn)).T
    shift = np.array(move.shift)
    points = marks.points.copy()
    slides = _turned(marks.slides, numbers, linear)
    partners = [] if symmetric_on is None else _mirrored_points(marks, group)
    if symmetric_on is None or not partners or set(partners) & set(numbers):
        points[numbers] = _about_centre(points, numbers, linear, numbers) + shift
        return _placed(marks, points, numbers, slides)
    mirror = mirror_map(marks.points, symmetric_on)
    other = mirror @ linear @ mirror
    # About what is known on both sides, so that these make mirrored moves.
    paired = [k for k in numbers if MIRRORED[k] in partners]
    points[numbers] = _about_centre(points, numbers, linear, paired) + shift
    points[partners] = _about_centre(points, partners, other, [MIRRORED[k] for k in paired]) + mirror @ shift
    return _placed(marks, points, [*numbers, *partners], _turned(slides, partners, other))


def switch_off(marks: Landmarks, numbers: list[int]) -> Landmarks:
    """Landmarks of which some are no longer known.

    Raises InputError for no such point, and where too few would be left.
    """
    _check_numbers(marks, numbers)
    points = marks.points.copy()
    points[numbers] = np.nan
    spreads = _changed(marks.spreads, numbers, np.nan)
    visibility = _changed(marks.visibility, numbers, 0.0)
    slides = _changed(marks.slides, numbers, 0.0)
    return replace(marks, points=points, spreads=spreads, visibility=visibility, slides=slides)


def group_points(marks: Landmarks, group: str) -> list[int]:
    """Numbers of the known points of a group. Raises InputError where there are none, or no such group."""
    if group not in (FACE, *GROUPS):
        raise InputError(f"group: expected {', '.join([FACE, *GROUPS])}, found {group}")
    numbers = [k for k in _numbers(marks, group) if marks.known[k]]
    if not numbers:
        raise InputError(f"group: expected a known point of {group}, found none")
    return numbers


def _mirrored_points(marks: Landmarks, group: str) -> list[int]:
    """Numbers of the known points of a group on the other side of the face."""
    mates = [MIRRORED[k] for k in _numbers(marks, group)]
    return [k for k in mates if marks.known[k]]


def _numbers(marks: Landmarks, group: str) -> list[int]:
    """Numbers of all points of a group that landmarks of their scheme have."""
    every = range(len(marks.points)) if group == FACE else GROUPS[group]
    return [k for k in every if k < len(marks.points)]


def _about_centre(points: np.ndarray, numbers: list[int], linear: np.ndarray, centred: list[int]) -> np.ndarray:
    """(K, 2) of points (L, 2), those of some numbers under a linear map (2, 2) about the centre of others, or, where
    there are none, about their own."""
    centre = points[centred or numbers].mean(0)
    return (points[numbers] - centre) @ linear.T + centre


def _placed(marks: Landmarks, points: np.ndarray, moved: list[int], slides: np.ndarray | None) -> Landmarks:
    """Landmarks at other points (L, 2), those that moved as sure as a hand is. slides: of Landmarks."""
    sure = (BY_HAND * marks.diagonal) ** 2 * np.eye(2)
    spreads = _changed(marks.spreads, moved, sure)
    visibility = _changed(marks.visibility, moved, 1.0)
    return replace(marks, points=points, spreads=spreads, visibility=visibility, slides=slides)


def _turned(slides: np.ndarray | None, numbers: list[int], linear: np.ndarray) -> np.ndarray | None:
    """Slides (L, 2), those of some numbers under a linear map (2, 2); None where there are none."""
    return None if slides is None else _changed(slides, numbers, slides[numbers] @ linear.T)


def _changed(values: np.ndarray | None, numbers: list[int], value: np.ndarray | float) -> np.ndarray | None:
    """Values (L, ...) with others for some numbers; None where there are none."""
    if values is None:
        return None
    changed = values.copy()
    changed[numbers] = value
    return changed


def _check_numbers(marks: Landmarks, numbers: list[int]) -> None:
    """Refuse numbers that no point has."""
    for number in numbers:
        if not 0 <= number < len(marks.points):
            raise InputError(f"point: expected a number from 0 to {len(marks.points) - 1}, found {number}")
