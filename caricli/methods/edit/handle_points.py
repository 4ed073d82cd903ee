"""Handles as a person writes them, to vertices and displacements."""

import difflib
import re

import numpy as np

from caricli.errors import InputError
from caricli.structures.landmarks import POINT_NAMES

_FARTHEST = 0.5
_SAME = 1e-9


def vertex_of(where, template):
    """The vertex id of a place: a vertex index, a landmark such as ``l30``, or one of POINT_NAMES.

    Raises InputError, which names what is near, when there is no such place.
    """
    note, text = template.annotation, str(where).strip()
    if text.isascii() and text.isdigit():
        if int(text) >= len(template.vertices):
            raise InputError(f"handle {text}: expected a vertex from 0 to {len(template.vertices) - 1}")
        return int(text)
    number = int(text[1:]) if re.fullmatch(r"l\d{1,4}", text, re.ASCII) else POINT_NAMES.get(text)
    if number is None:
        near = difflib.get_close_matches(text, POINT_NAMES, 1)
        known = f"expected a vertex, l0 to l80 or one of {', '.join(POINT_NAMES)}"
        hint = f"did you mean {near[0]}?" if near else known
        raise InputError(f"handle {text[:40]!r} is not known; {hint}")
    if number >= len(note.landmarks):
        raise InputError(f"handle {text}: expected a landmark from l0 to l{len(note.landmarks) - 1}")
    return int(note.landmarks[number])


def displacement_of(values, height, where):
    """Three lengths, metres or such as "5%" of the head's height, to (3,) metres. Raises InputError."""
    if not isinstance(values, list | tuple) or len(values) != 3:
        raise InputError(f"handle {where}: expected three lengths dx,dy,dz, found {values!r}")
    lengths = []
    for value in values:
        text = str(value).strip()
        try:
            lengths.append(float(text.removesuffix("%")) * (height / 100 if text.endswith("%") else 1))
        except ValueError:
            raise InputError(f"handle {where}: expected metres or a share such as 5%, found {text[:40]!r}") from None
    displacement = np.array(lengths)
    # nan is not small either.
    if not np.linalg.norm(displacement) <= _FARTHEST * height:
        most = _FARTHEST * height
        raise InputError(f"handle {where}: expected at most {most:.3f} m, half the head's height, found {lengths}")
    return displacement


def handle_points(asked, pins, template, symmetric=False):
    """Places and displacements to what ``edit_handles`` takes.

    asked: list of pairs (where, three lengths). pins: places that stay. template: Template. symmetric: add the mirror
    images.
    Returns (handles (H,) vertex ids, displacements (H, 3) metres, names (H,)).
    Raises InputError for unknown places and lengths, and for handles that contradict each other.
    """
    found = {}

    def add(vertex, displacement, name):
        known = found.setdefault(vertex, (displacement, name))
        if np.abs(known[0] - displacement).max() > _SAME:
            raise InputError(f"handles {known[1]} and {name} contradict each other: both are vertex {vertex}")

    if symmetric and template.annotation.mirror is None:
        raise InputError("--symmetric: this topology's annotation has no mirror map")
    pairs = [(where, displacement_of(values, template.height, where)) for where, values in asked]
    for where, displacement in [*pairs, *((pin, np.zeros(3)) for pin in pins)]:
        vertex = vertex_of(where, template)
        add(vertex, displacement, str(where))
        if symmetric:
            add(int(template.annotation.mirror[vertex]), displacement * [-1, 1, 1], f"{where} mirrored")
    moved = [displacement for displacement, _ in found.values()]
    if not np.any(moved):
        raise InputError("expected a handle that moves, found none")
    return np.array(list(found)), np.array(moved), [name for _, name in found.values()]
