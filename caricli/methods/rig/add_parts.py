"""Parts of a head for a rig, and a rig of fewer parts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from caricli.geometry.join_meshes import join_meshes
from caricli.structures import Depiction, HeadChoice, Material, Mesh, Part, Rig

_STILL = 1e-6
"""Metres: what moves no farther does not move, but for rounding."""


def add_parts(rig: Rig, parts: Sequence[Part]) -> Rig:
    """The rig with parts as part of its mesh: own polygons and UVs, moved by the expressions that they know by name.

    rig: Rig. parts: placed on its neutral face.
    Returns Rig; its own vertices come first, then those of the parts in their order; polygons stand by their material.
    """
    if not parts:
        return rig
    joined = join_meshes([rig.mesh, *(part.mesh for part in parts)])
    own = np.full(len(rig.mesh.polygons), Material.SKIN) if rig.materials is None else rig.materials
    materials = np.concatenate([own, *(part.materials for part in parts)])
    # Files keep polygons by their material.
    order = np.argsort(materials, kind="stable")
    uv_polygons = None if joined.uv_polygons is None else joined.uv_polygons[order]
    return replace(
        rig,
        mesh=Mesh(joined.vertices.astype(np.float32), joined.polygons[order], joined.uvs, uv_polygons),
        deltas=np.concatenate([rig.deltas, *(_deltas(part, rig.names) for part in parts)], axis=1, dtype=np.float32),
        materials=materials[order].astype(np.int32),
        depiction=_with_more(rig.depiction, [part.mesh.vertices for part in parts]),
    )


def choose_parts(rig: Rig, choice: HeadChoice) -> Rig:
    """The rig without the polygons of other parts and the vertices of these alone.

    choice: HeadChoice, of which the parts count. Returns Rig, without materials where only the skin is left; vertices
    and UVs that are left keep their order.
    """
    if rig.materials is None or choice.takes(rig.materials):
        return rig
    mesh = rig.mesh
    kept = np.isin(rig.materials, choice.materials)
    left, polygons = _left(mesh.polygons, kept, len(mesh.vertices))
    uvs = mesh.uvs
    uv_polygons = mesh.uv_polygons
    if uvs is not None and uv_polygons is not None:
        left_uvs, uv_polygons = _left(uv_polygons, kept, len(uvs))
        uvs = uvs[left_uvs]
    materials = rig.materials[kept]
    return replace(
        rig,
        mesh=Mesh(mesh.vertices[left], polygons, uvs, uv_polygons),
        deltas=rig.deltas[:, left],
        # What is all skin can be given parts again.
        materials=materials if (materials != Material.SKIN).any() else None,
        depiction=rig.depiction and replace(rig.depiction, vertices=rig.depiction.vertices[left]),
    )


def _left(polygons: np.ndarray, kept: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points that are left without some polygons (P, N), padded with -1: all but the corners of these alone.

    kept: (P,) bool. count: of points. Returns the numbers of the points, and the kept polygons between them.
    """
    dropped = np.setdiff1d(polygons[~kept], polygons[kept])
    left = np.setdiff1d(np.arange(count), dropped)
    number = np.full(count + 1, -1, np.int32)
    number[left] = np.arange(len(left))
    return left, number[polygons[kept]]


def _with_more(depiction: Depiction | None, more: Sequence[np.ndarray]) -> Depiction | None:
    """A Depiction with further vertices (W, 3) each, or None where there is none."""
    if depiction is None:
        return None
    return replace(depiction, vertices=np.concatenate([depiction.vertices, *more], dtype=np.float32))


def _deltas(part: Part, names: Sequence[str]) -> np.ndarray:
    """(K, W, 3) what expressions of these names do to a part: nothing where it does not know them."""
    deltas = np.zeros((len(names), *part.mesh.vertices.shape), np.float32)
    for k, name in enumerate(names):
        if name in part.names:
            moved = part.deltas[part.names.index(name)]
            deltas[k] = np.where((np.abs(moved) > _STILL).any(1, keepdims=True), moved, 0)
    return deltas
