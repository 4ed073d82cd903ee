"""Handles as a person writes them, to vertices and displacements."""

import difflib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.parse_number import parse_number
from caricli.structures.landmarks import POINT_NAMES
from caricli.template.template import Template

_FARTHEST = 0.5
"""Of the head's height, the most that a handle is moved: beyond it no face is left."""

_MOST_DIGITS = 18
"""Of a vertex index."""

_SAME = 1e-9
"""Metres: displacements of one vertex that differ by less do not contradict each other."""


@dataclass(frozen=True, eq=False)
class Handles:
    """Points of a face that are moved, or held where they are.

    vertices: (H,) vertex ids, distinct.
    displacements: (H, 3) metres, zero for what is to stay.
    names: H texts, what a person calls them.
    """

    vertices: np.ndarray
    displacements: np.ndarray
    names: tuple[str, ...]

    def scaled(self, share: float) -> "Handles":
        """The same points moved by a share of the way."""
        return replace(self, displacements=share * self.displacements)


def handle_points(
    asked: Sequence[tuple[object, object]], pins: Sequence[str], head: Template, symmetric: bool = False
) -> Handles:
    """Places and displacements as they are written to Handles.

    asked: pairs (where, three lengths), see ``vertex_of`` and ``displacement_of``.
    pins: places that stay.
    head: Template in the shape of the face that is edited: shares are of its height.
    symmetric: add the mirror images.
    Raises InputError for unknown places and lengths, and for handles that contradict each other.
    """
    if symmetric and head.annotation.mirror is None:
        raise InputError("expected a head with a mirror map for what is symmetric, found none")
    wanted = [(where, displacement_of(values, head.height, where)) for where, values in asked]
    wanted += [(pin, np.zeros(3)) for pin in pins]
    handles: dict[int, tuple[np.ndarray, str]] = {}
    for vertex, displacement, name in _placed(wanted, head, symmetric):
        other, other_name = handles.setdefault(vertex, (displacement, name))
        if np.abs(other - displacement).max() > _SAME:
            raise InputError(f"handles {other_name} and {name} contradict each other: both are vertex {vertex}")
    displacements = np.array([displacement for displacement, _ in handles.values()])
    # Ways whose squares are nothing have no share that was reached.
    if not (displacements**2).any():
        raise InputError("expected a handle that moves, found none")
    return Handles(np.array(list(handles)), displacements, tuple(name for _, name in handles.values()))


def vertex_of(where: object, head: Template) -> int:
    """The vertex id of a place: a vertex index, a landmark such as ``l30``, or one of POINT_NAMES.

    Raises InputError, which names what is near, when there is no such place.
    """
    landmarks = head.annotation.landmarks
    text = str(where).strip()
    if text.isascii() and text.isdigit():
        # Whatever it is, so many digits are beyond the last vertex.
        vertex = int(text) if len(text) <= _MOST_DIGITS else len(head.vertices)
        if vertex >= len(head.vertices):
            raise InputError(f"handle {text[:40]}: expected a vertex from 0 to {len(head.vertices) - 1}")
        return vertex
    number = int(text[1:]) if re.fullmatch(r"l\d{1,4}", text, re.ASCII) else POINT_NAMES.get(text)
    if number is None:
        near = difflib.get_close_matches(text, POINT_NAMES, 1)
        places = f"expected a vertex, l0 to l80 or one of {', '.join(POINT_NAMES)}"
        hint = f"did you mean {near[0]}?" if near else places
        raise InputError(f"handle {shown(text, 40)!r} is not known; {hint}")
    if number >= len(landmarks):
        raise InputError(f"handle {text}: expected a landmark from l0 to l{len(landmarks) - 1}")
    return int(landmarks[number])


def displacement_of(values: object, height: float, where: object) -> np.ndarray:
    """Three lengths to (3,) metres.

    values: list of numbers or texts, metres, or such as "5%" of the head's height. height: of the head, metres.
    where: the place, for messages.
    Raises InputError for other values, and for more than half the height.
    """
    if not isinstance(values, list | tuple) or len(values) != 3:
        raise InputError(f"handle {shown(where, 40)}: expected three lengths dx,dy,dz, found {shown(values, 60)}")
    lengths = []
    for value in values:
        text = str(value).strip()
        try:
            lengths.append(parse_number(text.removesuffix("%")) * (height / 100 if text.endswith("%") else 1))
        except ValueError:
            given = shown(text, 40)
            expected = "metres or a share such as 5%"
            raise InputError(f"handle {shown(where, 40)}: expected {expected}, found {given!r}") from None
    # Before their squares, which may be too large for any number.
    longest = math.hypot(*lengths)
    if longest > _FARTHEST * height:
        expected = f"at most {_FARTHEST * height:.3f} m, half the head's height"
        raise InputError(f"handle {shown(where, 40)}: expected {expected}, found {lengths}")
    return np.array(lengths)


def _placed(
    wanted: list[tuple[object, np.ndarray]], head: Template, symmetric: bool
) -> Iterator[tuple[int, np.ndarray, str]]:
    """Vertex, displacement and name of every handle, each followed by its mirror image where these are wanted."""
    for where, displacement in wanted:
        vertex = vertex_of(where, head)
        yield vertex, displacement, str(where)
        if symmetric and head.annotation.mirror is not None:
            yield int(head.annotation.mirror[vertex]), displacement * [-1, 1, 1], f"{where} mirrored"
