"""Which primitives of a glTF document are one rig, and where they are in it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from caricli.errors import InputError
from caricli.io.gltf.document import Document
from caricli.io.gltf.format import SOURCE_VERTEX
from caricli.io.gltf.materials import kind_of, material_of, placing_of
from caricli.io.gltf.scene import node_transform, numbers, resting_placements
from caricli.io.strict_json import take, take_whole
from caricli.limits import MAX_SHAPES, MAX_VERTICES
from caricli.structures import Material

_WORN = {*Material} - {Material.SKIN, Material.CLOTH}
"""What a mesh that keeps still may be of to be a part of a head: a body and what it wears are none."""


@dataclass(frozen=True, eq=False)
class RigPart:
    """A primitive of a rig.

    primitive: object with as many targets as the rig has, in their order. placement: (4,4), from the primitive's own
    axes to those of the rig.
    """

    primitive: dict
    placement: np.ndarray


@dataclass(frozen=True, eq=False)
class _Placed:
    """A mesh of the scene: the object, its primitives, and the transform (4,4) of its node."""

    mesh: dict
    primitives: list[dict]
    placement: np.ndarray

    @property
    def target_count(self) -> int:
        """How many targets all of its primitives have; 0 where they have not the same number."""
        numbers_of_targets = {len(take(primitive, "targets", list, [])) for primitive in self.primitives}
        return numbers_of_targets.pop() if len(numbers_of_targets) == 1 else 0


def rig_parts(document: Document) -> tuple[tuple[str, ...], list[RigPart], bool]:
    """What makes a rig: the mesh with most targets, of several the one with most skin, or where none has any the first
    one, and what belongs to it.

    What keeps still right below its node belongs to it where all its vertices say where they come from, as the mesh's
    do, and else where it is hair. So do meshes elsewhere in the scene that reach into its box and have targets of its
    names, or keep still and are said to be of eyes, teeth, hair or such: a program may have taken the head apart. Where
    its node is says nothing, for there the head turns.
    Returns the names of the targets, the primitives, those of the mesh first, and whether all of these say where their
    vertices come from. Raises InputError.
    """
    mesh, primitives = _head(document)
    names = _target_names(mesh, len(primitives[0]["targets"]))
    scene = [_Placed(other, primitives_of(other), placement) for other, placement in resting_placements(document)]
    placement = next((each.placement for each in scene if each.mesh is mesh), np.eye(4))
    head = _Placed(mesh, primitives, placement)
    stance = placement.copy()
    stance[:3, 3] = 0
    parts = [RigPart(primitive, stance) for primitive in primitives]
    taken = [mesh]
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it no mesh takes
        for below, transform in _below(document, head):
            taken.append(below)
            parts += [RigPart(_still(each, len(names)), stance @ transform) for each in primitives_of(below)]
        for other in scene if names else []:
            if not any(other.mesh is each for each in taken) and _belongs(document, head, other):
                taken.append(other.mesh)
                parts += _named_parts(other, names, other.placement - _shift(placement))
    return names, parts, is_ours(primitives)


def is_ours(primitives: list[dict]) -> bool:
    """Whether all vertices say where they come from."""
    return all(SOURCE_VERTEX in take(primitive, "attributes", dict) for primitive in primitives)


def primitives_of(mesh: object) -> list[dict]:
    """The primitives of a mesh. Raises InputError where they are none."""
    primitives = take(mesh, "primitives", list) if isinstance(mesh, dict) else []
    if not all(isinstance(primitive, dict) for primitive in primitives):
        raise InputError("primitives: expected objects, found others")
    return primitives


def _head(document: Document) -> tuple[dict, list[dict]]:
    """The mesh that is the head, and its primitives, all with the same number of targets.

    Those of nodes below others come last: Blender writes them first.
    """
    meshes = list(enumerate(take(document.content, "meshes", list, [])))
    below = _meshes_below(document)
    ordered = [mesh for _, mesh in sorted(meshes, key=lambda entry: entry[0] in below)]
    placed = [_Placed(mesh, primitives_of(mesh), np.eye(4)) for mesh in ordered]
    whole = [each for each in placed if each.primitives]
    if not whole:
        raise InputError("expected a mesh, found none")
    first = whole[0]
    moving = [each for each in whole if any(primitive.get("targets") for primitive in each.primitives)]
    if not moving:
        return first.mesh, [_still(primitive, 0) for primitive in first.primitives]
    head = max(moving, key=partial(_size, document))
    if not 0 < head.target_count <= MAX_SHAPES:
        counts = {len(take(primitive, "targets", list, [])) for primitive in head.primitives}
        raise InputError(f"targets: expected as many in every primitive, at most {MAX_SHAPES}, found {counts}")
    return head.mesh, head.primitives


def _meshes_below(document: Document) -> set[int]:
    """Numbers of the meshes whose nodes are children of others."""
    nodes = [node for node in take(document.content, "nodes", list, []) if isinstance(node, dict)]
    children = [child for node in nodes for child in take(node, "children", list, [])]
    below = [document.item({"node": child}, "node", "nodes").get("mesh") for child in children]
    return {number for number in below if type(number) is int}


def _below(document: Document, head: _Placed) -> Iterator[tuple[dict, np.ndarray]]:
    """The meshes right below the node of a head that keep still and belong to it, with the transforms (4,4) of their
    nodes."""
    number = next(k for k, other in enumerate(document.content["meshes"]) if other is head.mesh)
    nodes = [node for node in take(document.content, "nodes", list, []) if isinstance(node, dict)]
    children = take(next((node for node in nodes if node.get("mesh") == number), {}), "children", list, [])
    for child in children:
        node = document.item({"node": child}, "node", "nodes")
        mesh = {} if "mesh" not in node else document.item(node, "mesh", "meshes")
        primitives = primitives_of(mesh) if mesh else []
        belongs = is_ours(primitives) if is_ours(head.primitives) else _is_hair(document, primitives)
        if belongs and not any(primitive.get("targets") for primitive in primitives):
            yield mesh, node_transform(node)


def _belongs(document: Document, head: _Placed, other: _Placed) -> bool:
    """Whether a mesh elsewhere in the scene is a part of a head with targets."""
    if is_ours(other.primitives) != is_ours(head.primitives) or not _touch(document, head, other):
        return False
    if _is_placed(document, head.primitives) and not _is_placed(document, other.primitives):
        return False
    if any(primitive.get("targets") for primitive in other.primitives):
        # Skin of as many vertices is another head.
        is_other = _size(document, other)[1:] >= _size(document, head)[1:]
        return _names_agree(head, other) and not is_other
    return _kinds(document, other.primitives) <= _WORN


def _names_agree(head: _Placed, other: _Placed) -> bool:
    """Whether the targets of a mesh are among those of a head; where nothing names them, they are as many."""
    count = other.target_count
    if not count:
        return False
    names = _target_names(other.mesh, count)
    named = isinstance(other.mesh.get("extras"), dict) and "targetNames" in other.mesh["extras"]
    return (named or count == head.target_count) and set(names) <= {*_target_names(head.mesh, head.target_count)}


def _named_parts(mesh: _Placed, names: tuple[str, ...], placement: np.ndarray) -> list[RigPart]:
    """The primitives of a mesh with the targets of other names, {} for those that it has not."""
    own = _target_names(mesh.mesh, mesh.target_count)
    parts = []
    for primitive in mesh.primitives:
        targets = dict(zip(own, take(primitive, "targets", list, []), strict=True))
        parts.append(RigPart(primitive | {"targets": [targets.get(name, {}) for name in names]}, placement))
    return parts


def _touch(document: Document, head: _Placed, other: _Placed) -> bool:
    """Whether the boxes of two meshes overlap where their nodes put them; False where one is not told."""
    first = _box(document, head)
    second = _box(document, other)
    if first is None or second is None:
        return False
    return bool((first[0] <= second[1]).all() and (second[0] <= first[1]).all())


def _box(document: Document, mesh: _Placed) -> np.ndarray | None:
    """The lowest and the highest coordinates (2,3) of a mesh, or None where its accessors do not tell them all."""
    corners = []
    for primitive in mesh.primitives:
        accessor = document.item(take(primitive, "attributes", dict), "POSITION", "accessors")
        if not {"min", "max"} <= set(accessor):
            return None
        ends = np.stack([numbers(accessor, key, 3) for key in ("min", "max")])
        corners.append(np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3))
    if not corners:
        return None
    where = np.concatenate(corners) @ mesh.placement[:3, :3].T + mesh.placement[:3, 3]
    return np.stack([where.min(0), where.max(0)])


def _size(document: Document, mesh: _Placed) -> tuple[int, bool, int]:
    """What tells a head from its parts: how many targets it has, whether skin is among it, and how many vertices it
    has; primitives that share these share an accessor."""
    accessors = [document.item(take(each, "attributes", dict), "POSITION", "accessors") for each in mesh.primitives]
    distinct = {id(accessor): accessor for accessor in accessors}.values()
    count = sum(take_whole(accessor, "count", 1, MAX_VERTICES) for accessor in distinct)
    return mesh.target_count, Material.SKIN in _kinds(document, mesh.primitives), count


def _is_hair(document: Document, primitives: list[dict]) -> bool:
    """Whether all is hair with a place in a picture."""
    return _kinds(document, primitives) == {Material.HAIR} and _is_placed(document, primitives)


def _kinds(document: Document, primitives: list[dict]) -> set[Material]:
    """What primitives are of."""
    return {kind_of(material_of(document, primitive)) for primitive in primitives}


def _is_placed(document: Document, primitives: list[dict]) -> bool:
    """Whether all vertices have a place in a picture."""
    return all(
        placing_of(material_of(document, primitive)).key in take(primitive, "attributes", dict)
        for primitive in primitives
    )


def _still(primitive: dict, count: int) -> dict:
    """A primitive with as many targets that move nothing."""
    return primitive | {"targets": [{}] * count}


def _shift(placement: np.ndarray) -> np.ndarray:
    """What a transform (4,4) moves alone, to be taken from another one."""
    shift = np.zeros((4, 4))
    shift[:3, 3] = placement[:3, 3]
    return shift


def _target_names(mesh: dict, count: int) -> tuple[str, ...]:
    """The names of the targets, which glTF leaves to custom; where there are none, names are what is left of some."""
    if not count:
        return ()
    extras = mesh.get("extras")
    names = extras.get("targetNames") if isinstance(extras, dict) else None
    if names is None:
        return tuple(f"target_{k}" for k in range(count))
    if not isinstance(names, list) or len(names) != count or not all(isinstance(name, str) for name in names):
        raise InputError(f"targetNames: expected {count} names, found others")
    return tuple(names)
