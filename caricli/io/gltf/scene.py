"""Where the nodes of a glTF scene put their meshes."""

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from caricli.errors import InputError
from caricli.io.gltf.document import Document
from caricli.io.strict_json import take, take_whole
from caricli.structures.checks import shape_problem

_MAX_NODES = 16384


def resting_placements(document: Document) -> Iterator[tuple[dict, np.ndarray]]:
    """``node_placements``, where what an animation moves is left aside."""
    moving: dict[int, set[str]] = {}
    for animation in take(document.content, "animations", list, []):
        for channel in take(animation, "channels", list, []) if isinstance(animation, dict) else ():
            target = take(channel, "target", dict, {}) if isinstance(channel, dict) else {}
            if "node" in target:
                moving.setdefault(take_whole(target, "node", 0, _MAX_NODES), set()).add(str(target.get("path")))
    return node_placements(document, moving)


def node_placements(
    document: Document, without: Mapping[int, Collection[str]] | None = None
) -> Iterator[tuple[dict, np.ndarray]]:
    """The meshes of the scene with the transform (4,4) of each of their nodes; all meshes where there is no scene.

    without: by the numbers of nodes, what of their transforms does not count.
    Raises InputError when the nodes are no tree, too many, or a transform is none.
    """
    content = document.content
    if not take(content, "scenes", list, []):
        yield from ((mesh, np.eye(4)) for mesh in take(content, "meshes", list, []))
        return
    scene = document.item({"scene": content.get("scene", 0)}, "scene", "scenes")
    waiting = [(number, np.eye(4)) for number in reversed(take(scene, "nodes", list, []))]
    visited: set[int] = set()
    while waiting:
        number, above = waiting.pop()
        node = document.item({"node": number}, "node", "nodes")
        if number in visited or len(visited) >= _MAX_NODES:
            raise InputError(f"nodes: expected a tree of at most {_MAX_NODES} nodes, found another")
        visited.add(number)
        with np.errstate(over="ignore", invalid="ignore"):  # what comes of it no mesh takes
            placement = above @ node_transform(node, (without or {}).get(number, ()))
        if "mesh" in node:
            # The specification has skinned meshes ignore where their node is.
            yield document.item(node, "mesh", "meshes"), np.eye(4) if "skin" in node else placement
        waiting += [(child, placement) for child in reversed(take(node, "children", list, []))]


def node_transform(node: dict, without: Collection[str] = ()) -> np.ndarray:
    """The transform (4,4) of a node, from its matrix or its translation, rotation and scale, ``without`` some of them.

    Raises InputError.
    """
    node = {key: value for key, value in node.items() if key not in without}
    if "matrix" in node:
        return numbers(node, "matrix", 16).reshape(4, 4).T
    transform = np.eye(4)
    if "rotation" in node:
        transform[:3, :3] = _rotation(numbers(node, "rotation", 4))
    if "scale" in node:
        transform[:3, :3] *= numbers(node, "scale", 3)
    if "translation" in node:
        transform[:3, 3] = numbers(node, "translation", 3)
    return transform


def numbers(holder: dict, key: str, count: int) -> np.ndarray:
    """So many numbers of a key, float64. Raises InputError when it has none or others."""
    values = take(holder, key, list)
    sound = len(values) == count and all(type(value) in (int, float) and abs(value) < 1e30 for value in values)
    array = np.array(values, np.float64) if sound else np.zeros(0)
    problem = shape_problem(key, array, (count,))
    if problem:
        raise InputError(problem)
    return array


def _rotation(quaternion: np.ndarray) -> np.ndarray:
    """The rotation (3,3) of a quaternion xyzw."""
    from scipy.spatial.transform import Rotation

    if not 0.5 <= np.linalg.norm(quaternion) <= 2:
        raise InputError("rotation: expected a unit quaternion, found another")
    return Rotation.from_quat(quaternion).as_matrix()
