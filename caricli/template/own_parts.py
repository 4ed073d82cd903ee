"""Parts that somebody brings with an own topology."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.meshes.mesh import read_mesh
from caricli.structures import Material, Mesh, Part
from caricli.structures.materials import MATERIALS
from caricli.template.annotation import Annotation
from caricli.template.template import FittedParts, Template

BEYOND = 0.1
"""Of the head's height: how far a part may stand out of the box around its head."""

_USUAL = {"teeth": Material.TEETH, "gums": Material.GUMS, "tongue": Material.TONGUE, "lashes": Material.LASHES}
_ARRAYS = ("vertices", "polygons", "uvs", "uv_polygons", "materials")


def read_own_parts(template: Template, annotation_path: Path, head: np.ndarray, factor: float) -> FittedParts | None:
    """The parts that an annotation names, or None.

    template: with the annotation. annotation_path: in whose folder the files lie. head: (V, 3) metres, of the mesh that
    the parts were modelled in. factor: from the files' unit to metres.
    Raises InputError for a file that is not a mesh, lies elsewhere, or does not fit the head.
    """
    entries = template.annotation.source.get("parts", {})
    if not entries:
        return None
    fitted = template.with_vertices(head)
    parts = []
    for name, entry in entries.items():
        file = annotation_path.parent / entry["file"]
        if not _is_inside(file, annotation_path.parent):
            elsewhere = shown(entry["file"], 60)
            raise InputError(f"{shown(annotation_path)}: parts.{name}: expected a file beside it, found {elsewhere!r}")
        mesh = read_mesh(file)
        placed = mesh.with_vertices(np.asarray(mesh.vertices, float) * factor)
        with naming(file):
            _check_place(placed, fitted)
            material = _material(name, entry.get("material"))
        parts.append(_part(name, placed, np.full(len(mesh.polygons), material, np.int32), template.annotation))
    return FittedParts(fitted, tuple(parts))


def _is_inside(file: Path, folder: Path) -> bool:
    try:
        return file.resolve().is_relative_to(folder.resolve())
    except (ValueError, RuntimeError):  # a null byte, or a link that leads to itself
        return False


def parts_to_arrays(fitted: FittedParts | None) -> dict[str, np.ndarray]:
    """Arrays by name, from which ``parts_from_arrays`` makes them again."""
    if fitted is None:
        return {}
    arrays = {"parts.head": np.asarray(fitted.head.vertices, float)}
    for part in fitted.parts:
        values = {name: getattr(part.mesh, name, None) for name in _ARRAYS} | {"materials": part.materials}
        arrays |= {f"parts.{part.name}.{name}": value for name, value in values.items() if value is not None}
    return arrays


def parts_from_arrays(arrays: Mapping[str, np.ndarray], template: Template) -> FittedParts | None:
    """Parts from a file; the template's annotation names them. Raises InputError where they do not fit it."""
    holds = template.annotation.holds
    if not holds:
        return None
    try:
        head = template.with_vertices(np.asarray(arrays["parts.head"], float))
        parts = []
        for name in holds:
            values = {key: arrays[f"parts.{name}.{key}"] for key in _ARRAYS}
            materials = np.asarray(values.pop("materials"))
            parts.append(_part(name, Mesh(**values), materials, template.annotation))
    except KeyError as error:
        raise InputError(f"expected the parts that the annotation names, without {shown(error, 60)}") from error
    return FittedParts(head, tuple(parts))


def _part(name: str, mesh: Mesh, materials: np.ndarray, annotation: Annotation) -> Part:
    if mesh.uvs is None:
        mesh = Mesh(mesh.vertices, mesh.polygons, np.zeros((1, 2)), np.where(mesh.polygons >= 0, 0, -1))
    none = np.zeros((0, len(mesh.vertices), 3))
    return Part(name, mesh, materials, annotation.holds[name], (), none)


def _check_place(part: Mesh, head: Mesh) -> None:
    room = BEYOND * head.height
    low = head.vertices.min(0) - room
    high = head.vertices.max(0) + room
    beyond = np.maximum(low - part.vertices, part.vertices - high).max()
    if beyond > 0:
        raise InputError(
            f"expected a part that fits the first mesh, {head.height:.3g} m high, found it {beyond + room:.3g} m "
            "outside of it"
        )


def _material(name: str, given: object) -> Material:
    usual = next((material for start, material in _USUAL.items() if name.startswith(start)), None)
    if given is None and usual is not None:
        return usual
    if not isinstance(given, str) or given not in MATERIALS:
        expected = ", ".join(MATERIALS)
        raise InputError(f"parts.{name}: expected a material ({expected}), found {shown(given, 40)!r}")
    return MATERIALS[given]
