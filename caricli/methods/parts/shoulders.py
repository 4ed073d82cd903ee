"""The shoulders under a head."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import igl
import numpy as np

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.npz import read_npz
from caricli.methods.parts.attachment import open_head_topology
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Material, Mesh, Part
from caricli.template.head import load_head

NO_SHOULDERS = "expected a skin of the bundled head's topology for shoulders (--bust), found another"
"""What is said of a face that cannot have them."""

BUST_FILE = "bust.npz"
"""Of the assets."""

COLLAR = 4
"""Loops of edges between the edge of the neck and a shirt."""

THICKNESS = 0.003
"""Metres that a shirt stands off the skin."""

REACH = 1.6
"""How far from the edge the neck gives way to shoulders that keep their shape, of the edge's mean radius."""


@dataclass(frozen=True, eq=False)
class Shoulders:
    """The bust of the open head in its usual shape, and what carries it to other faces.

    mesh: Mesh with UVs, as the picture of the neck goes; its first L vertices are those of the head's edge.
    edge: (L,) these in the head. near: (N,) vertices of the head, the edge and those beside it.
    before: (N, 3) metres, where they are on the head. spread: (W, N) how far the bust goes along with each.
    materials: (P,) int32, a Material for every polygon.
    """

    mesh: Mesh
    edge: np.ndarray
    near: np.ndarray
    before: np.ndarray
    spread: np.ndarray
    materials: np.ndarray

    def place(self, vertices: np.ndarray) -> np.ndarray:
        """(W, 3) where the bust is under a face (V, 3), metres."""
        after = vertices[self.near]
        # Upright, whichever way the edge is tilted: a bust stands level.
        scale = np.linalg.norm(after - after.mean(0)) / np.linalg.norm(self.before - self.before.mean(0))
        shift = after.mean(0) - scale * self.before.mean(0)
        places = scale * self.mesh.vertices + shift + self.spread @ (after - scale * self.before - shift)
        places[: len(self.edge)] = vertices[self.edge]
        return places

    def move(self, deltas: np.ndarray) -> np.ndarray:
        """(K, W, 3) what K expressions do to it that do (K, V, 3) to the face, metres: next to nothing off the edge."""
        moved = np.einsum("wn,knc->kwc", self.spread, deltas[:, self.near])
        moved[:, : len(self.edge)] = deltas[:, self.edge]
        return moved


def add_shoulders(
    skin: Mesh, vertices: np.ndarray, names: Sequence[str] = (), deltas: np.ndarray | None = None
) -> Part:
    """The shoulders of the head's own base mesh under a face, in place of what closes its neck.

    They are of the size of the neck and upright; beside its edge they go over into its shape, so that there is neither
    gap nor fold. They keep still in every expression, but for where the edge itself moves, and wear a plain shirt.

    skin: Mesh with the topology of the open head. vertices: (V, 3) metres, the face. names, deltas: K
    expressions and (K, V, 3) metres, what they do to the face.
    Returns a Part. Raises InputError for a skin of another topology.
    """
    if skin.topology_id != open_head_topology():
        raise InputError(NO_SHOULDERS)
    bust = open_head_shoulders()
    places = bust.place(np.asarray(vertices, float))
    moves = np.zeros((0, *np.shape(vertices))) if deltas is None else np.asarray(deltas, float)
    return Part("bust", bust.mesh.with_vertices(places), bust.materials, "neck", tuple(names), bust.move(moves))


@cache
def open_head_shoulders() -> Shoulders:
    """Of the open head in its usual shape."""
    arrays = read_npz(asset_path(BUST_FILE))
    edge = arrays.pop("edge")
    mesh, materials = _clothed(Mesh(**arrays), len(edge))
    head = load_head().template()
    beside = head.faces[np.isin(head.faces, edge).any(1)]
    near = np.concatenate([edge, np.setdiff1d(beside, edge)])
    # The faces beside the edge are joined on, so that the bust goes on in the direction of the skin.
    number = np.full(len(head.vertices), -1)
    number[edge] = np.arange(len(edge))
    number[near[len(edge) :]] = len(mesh.vertices) + np.arange(len(near) - len(edge))
    places = np.vstack([mesh.vertices, head.vertices[near[len(edge) :]]])
    faces = np.vstack([mesh.faces, number[beside]]).astype(np.int64)
    rim = head.vertices[edge]
    radius = np.linalg.norm(rim - rim.mean(0), axis=1).mean()
    away = np.linalg.norm(mesh.vertices[:, None] - rim, axis=2).min(1)
    far = np.nonzero(away > REACH * radius)[0]
    fixed = np.concatenate([number[near], far])
    values = np.eye(len(fixed), len(near))
    spread = np.asarray(igl.harmonic(places, faces, fixed, values, 2))[: len(mesh.vertices)]
    return Shoulders(mesh, edge, near, head.vertices[near], spread, materials)


def _clothed(mesh: Mesh, around: int) -> tuple[Mesh, np.ndarray]:
    """A bust with a shirt, which begins at a loop of its edges around the neck and stands off the skin.

    around: vertices of the neck's edge, which come first. Returns the Mesh and the Material of every polygon; the
    vertices of the loop are there twice, on the skin and on the shirt's edge, and a strip of shirt is between them.
    """
    assert mesh.uvs is not None and mesh.uv_polygons is not None
    used = mesh.polygons >= 0
    ring = _rings(mesh, around)
    nearest = np.where(used, ring[mesh.polygons], len(ring)).min(1)
    cloth = nearest >= COLLAR
    loop = np.nonzero(ring == COLLAR)[0]
    copy = np.arange(len(mesh.vertices))
    copy[loop] = len(mesh.vertices) + np.arange(len(loop))
    # The plate below is on vertices of its own, in the same places.
    _, first, same = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    off = THICKNESS * smooth_normals(mesh.vertices, mesh.faces)[first[same.ravel()]]
    vertices = mesh.vertices + (ring > COLLAR)[:, None] * off
    vertices = np.vstack([vertices, (mesh.vertices + off)[loop]])
    polygons = mesh.polygons.copy()
    polygons[cloth] = np.where(used[cloth], copy[mesh.polygons[cloth]], -1)
    strip, uv_strip = _strip(mesh, cloth, copy)
    materials = np.append(np.where(cloth, Material.CLOTH, Material.BUST), np.full(len(strip), Material.CLOTH))
    polygons = np.vstack([polygons, strip])
    return Mesh(vertices, polygons, mesh.uvs, np.vstack([mesh.uv_polygons, uv_strip])), materials.astype(np.int32)


def _rings(mesh: Mesh, around: int) -> np.ndarray:
    """(V,) how many polygons there are on the way to each vertex from the first ones; a part of its own is far off."""
    ring = np.full(len(mesh.vertices), len(mesh.vertices))
    ring[:around] = 0
    used = mesh.polygons >= 0
    for number in range(1, COLLAR + 2):
        beside = (ring[mesh.polygons] == number - 1) & used
        reached = np.unique(mesh.polygons[beside.any(1)])
        ring[reached[reached >= 0]] = np.minimum(ring[reached[reached >= 0]], number)
    return ring


def _strip(mesh: Mesh, cloth: np.ndarray, copy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quads (L, 4) between the edge of a shirt and the skin below it, and their places in the picture.

    cloth: (P,) bool, polygons of the shirt. copy: (V,) vertices of its edge by those of the skin; itself elsewhere.
    """
    assert mesh.uv_polygons is not None
    quads = []
    places = []
    for polygon, uv_polygon in zip(mesh.polygons[cloth], mesh.uv_polygons[cloth], strict=True):
        ids = polygon[polygon >= 0]
        uvs = uv_polygon[polygon >= 0]
        for a, b, u, v in zip(ids, np.roll(ids, -1), uvs, np.roll(uvs, -1), strict=True):
            if copy[a] != a and copy[b] != b:
                quads.append([a, b, copy[b], copy[a]])
                places.append([u, v, v, u])
    return np.array(quads, np.int32), np.array(places, np.int32)
