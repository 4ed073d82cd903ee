"""The shoulders under a head."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import igl
import numpy as np

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.npz import read_npz
from caricli.structures import Material, Mesh, Part
from caricli.template.head import load_head
from caricli.template.template import Template

NO_SHOULDERS = "expected a skin of the bundled head's topology for shoulders (--bust), found another"
"""What is said of a face that cannot have them."""

BUST_FILE = "bust.npz"
"""Of the assets."""

REACH = 1.6
"""How far from the edge the neck gives way to shoulders that keep their shape, of the edge's mean radius."""


@dataclass(frozen=True, eq=False)
class Shoulders:
    """The bust of the open head in its usual shape, and what carries it to other faces.

    mesh: Mesh with UVs, as the picture of the neck goes; its first L vertices are those of the head's edge.
    edge: (L,) these in the head. near: (N,) vertices of the head, the edge and those beside it.
    before: (N, 3) metres, where they are on the head. spread: (W, N) how far the bust goes along with each.
    """

    mesh: Mesh
    edge: np.ndarray
    near: np.ndarray
    before: np.ndarray
    spread: np.ndarray

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
    template: Template, vertices: np.ndarray, names: Sequence[str] = (), deltas: np.ndarray | None = None
) -> Part:
    """The shoulders of the head's own base mesh under a face, in place of what closes its neck.

    They are of the size of the neck and upright; beside its edge they go over into its shape, so that there is neither
    gap nor fold. They keep still in every expression, but for where the edge itself moves.

    template: Template with the topology of the open head. vertices: (V, 3) metres, the face. names, deltas: K
    expressions and (K, V, 3) metres, what they do to the face.
    Returns a Part. Raises InputError for a template of another topology.
    """
    head = load_head().template()
    if template.topology_id != head.topology_id:
        raise InputError(NO_SHOULDERS)
    bust = open_head_shoulders()
    places = bust.place(np.asarray(vertices, float))
    moves = np.zeros((0, *np.shape(vertices))) if deltas is None else np.asarray(deltas, float)
    materials = np.full(len(bust.mesh.polygons), Material.BUST, np.int32)
    return Part("bust", bust.mesh.with_vertices(places), materials, "neck", tuple(names), bust.move(moves))


@cache
def open_head_shoulders() -> Shoulders:
    """Of the open head in its usual shape."""
    arrays = read_npz(asset_path(BUST_FILE))
    edge = arrays.pop("edge")
    mesh = Mesh(**arrays)
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
    return Shoulders(mesh, edge, near, head.vertices[near], spread)
