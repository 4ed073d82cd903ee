"""What is known by name on a head: landmarks, jaw paths, curves, regions, mirror map, eyeballs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.bundled import asset_path
from caricli.io.strict_json import found_value, read_json, take
from caricli.structures.landmarks import COUNT, EXTRA, GROUPS, JAW
from caricli.structures.parts import Hold

_KEYS = (
    *("ibug68", "extra13", "extra13_names", "jaw_paths", "curves", "closed_curves", "regions", "mirror", "eyeballs"),
    *("parts", "template"),
)
"""Of an annotation's JSON; ``extra13_names`` and ``template`` are for its readers."""

CAVITIES = ("inner_mouth", "eye_socket_left", "eye_socket_right")
"""Regions that turn inwards, which neither landmarks nor pictures see."""

EARS = ("ear_left", "ear_right")
"""Regions of the two ears."""

DELICATE = ("eyes_left", "eyes_right", "eye_socket_left", "eye_socket_right", "mouth", "inner_mouth")
"""Regions where curvature says nothing about character: exaggeration by it leaves them as they are."""

HELD_BY: dict[Hold, tuple[str, ...]] = {"skull": ("skull",), "jaw": ("jaw",), "lids": ("eyes_left", "eyes_right")}
"""Regions that say where that is on which own parts may hang; one of them is enough."""


@dataclass(frozen=True)
class Annotation:
    """Vertex ids by name.

    landmarks: (68,) or (81,) vertex ids.
    jaw_paths: 17 arrays of vertex ids, back to front, along which the jaw's landmarks slide.
    curves, regions: vertex ids by name.
    mirror: (V,) the vertex on the other side of every vertex, or None.
    eyeballs: JSON object, as it was read.
    source: the JSON value that all this was read from, kept so that a checkpoint can carry it.
    holds: what every part of the topology hangs on, by the name of the part.
    """

    landmarks: np.ndarray
    jaw_paths: tuple[np.ndarray, ...]
    curves: dict[str, np.ndarray]
    regions: dict[str, np.ndarray]
    mirror: np.ndarray | None
    eyeballs: dict
    source: dict
    holds: dict[str, Hold] = field(default_factory=dict)

    @property
    def has_extra(self) -> bool:
        """Whether the 13 points beyond iBUG-68 are there."""
        return len(self.landmarks) == COUNT + len(EXTRA)

    def anchor_ids(self) -> np.ndarray:
        """Every vertex that a landmark can stand on, the jaw paths included, without repeats."""
        return np.unique(np.concatenate([self.landmarks, *self.jaw_paths]))


@cache
def bundled_annotation() -> Annotation:
    """The Annotation of the bundled head, without the head."""
    path = asset_path("head_annotation.json")
    value = read_json(path)
    return parse_annotation(value, len(value["mirror"]), path.name)


def parse_annotation(value: Any, vertex_count: int, where: str) -> Annotation:
    """Check an annotation's JSON value against a mesh.

    value: dict of the form of ``assets/head_annotation.json``; only ``ibug68`` is required. ``extra13``, ``jaw_paths``
    (17 lists of vertex ids, back to front), ``curves``, ``closed_curves`` (names of those that end where they begin),
    ``regions``, ``mirror``, ``eyeballs`` and ``parts`` (objects with ``file`` and ``hangs_on`` by name) may be absent;
    a curve or region without vertices is as good as absent. A vertex may be several landmarks of one of GROUPS, as on
    the closed lips of a coarse mesh, but at least half of a group's landmarks are vertices of their own.
    vertex_count: V. where: the file's name, for messages.
    Returns Annotation. Raises InputError.
    """
    if not isinstance(value, dict):
        kind = type(value).__name__
        raise InputError(f"{where}: expected a JSON object with vertex ids under 'ibug68', found {kind}")
    with naming(where):
        return _annotation(value, vertex_count)


def check_keys(value: Mapping[str, Any]) -> None:
    """Raise InputError for a key of an annotation's JSON that means nothing, and closed curves that it does not name.

    Models of before, which hold such a key, are read nevertheless.
    """
    unknown = [key for key in value if key not in _KEYS]
    if unknown:
        meant = "".join(f"; is {key} meant?" for key in get_close_matches(unknown[0], _KEYS, 1))
        raise InputError(f"expected keys of {', '.join(_KEYS)}, found {shown(unknown[0], 40)!r}{meant}")
    curves = value.get("curves", {})
    strange = [name for name in value.get("closed_curves", []) if name not in curves]
    if strange:
        raise InputError(f"closed_curves: expected names of curves, found {shown(strange[0], 40)!r}")


def _annotation(value: dict, vertex_count: int) -> Annotation:
    def ids(key: str, item: Any, count: int | None = None) -> np.ndarray:
        expected = f"{key}: expected a list of vertex ids from 0 to {vertex_count - 1}"
        if not isinstance(item, list):
            raise InputError(f"{expected}, found {found_value(item)}")
        for place, number in enumerate(item):
            if type(number) is not int or not 0 <= number < vertex_count:
                raise InputError(f"{expected}, found {found_value(number)} at {key}[{place}]")
        if count is not None and len(item) != count:
            raise InputError(f"{key}: expected {count} vertex ids, found {len(item)}")
        return np.array(item, np.int64)

    def table(key: str) -> dict[str, np.ndarray]:
        named = {name: ids(f"{key}.{name}", item) for name, item in take(value, key, dict, {}).items()}
        return {name: array for name, array in named.items() if len(array)}

    landmarks = ids("ibug68", value.get("ibug68"), COUNT)
    _check_own_vertices(landmarks)
    if "extra13" in value:
        landmarks = np.concatenate([landmarks, ids("extra13", value["extra13"], len(EXTRA))])
    jaw_paths = _jaw_paths(value, landmarks[JAW], ids)
    mirror = ids("mirror", value["mirror"], vertex_count) if "mirror" in value else None
    if mirror is not None and not np.array_equal(mirror[mirror], np.arange(vertex_count)):
        raise InputError("mirror: expected a map that is its own inverse, found another")
    regions = table("regions")
    holds: dict[str, Hold] = {}
    for name, part in take(value, "parts", dict, {}).items():
        with naming(f"parts.{name}"):
            holds[name] = _hold(part, regions)
    eyeballs = take(value, "eyeballs", dict, {})
    take(value, "closed_curves", list, [])
    return Annotation(landmarks, jaw_paths, table("curves"), regions, mirror, eyeballs, value, holds)


def _check_own_vertices(landmarks: np.ndarray) -> None:
    """Raise InputError where landmarks (68,) of two groups share a vertex, or those of one have too few."""
    groups: dict[int, str] = {}
    for group, numbers in GROUPS.items():
        if numbers.start >= COUNT:
            break
        vertices = set(landmarks[numbers].tolist())
        least = (len(numbers) + 1) // 2
        if len(vertices) < least:
            raise InputError(f"ibug68: expected at least {least} vertices for {group}, found {len(vertices)}")
        for vertex in vertices:
            other = groups.setdefault(vertex, group)
            if other != group:
                raise InputError(f"ibug68: expected other vertices for {group} than {other}, found {vertex} in both")


def _hold(part: Any, regions: dict[str, np.ndarray]) -> Hold:
    """What a part hangs on, checked against the regions that say where this is."""
    hold = part.get("hangs_on") if isinstance(part, dict) else None
    if not isinstance(hold, str) or hold not in HELD_BY:
        raise InputError(f"hangs_on: expected {' or '.join(HELD_BY)}, found {found_value(hold)}")
    take(part, "file", str)
    if not any(region in regions for region in HELD_BY[hold]):
        expected = " or ".join(f"'regions.{region}'" for region in HELD_BY[hold])
        raise InputError(f"expected {expected}, the vertices that it hangs on, found none")
    return hold


def _jaw_paths(value: dict, jaw: np.ndarray, ids: Callable) -> tuple[np.ndarray, ...]:
    paths = value.get("jaw_paths", [[int(i)] for i in jaw])
    if not isinstance(paths, list) or len(paths) != len(JAW):
        raise InputError(f"jaw_paths: expected {len(JAW)} lists of vertex ids, found {found_value(paths)}")
    jaw_paths = tuple(ids(f"jaw_paths[{k}]", path) for k, path in enumerate(paths))
    without = next((k for k, path in enumerate(jaw_paths) if jaw[k] not in path), None)
    if without is not None:
        expected = f"vertex {jaw[without]}, which slides along it"
        raise InputError(f"jaw_paths[{without}]: expected {expected}, found none")
    return jaw_paths
