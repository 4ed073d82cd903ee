"""Teeth, tongue and lashes put into a face and moved with its expressions."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np
from scipy.spatial import cKDTree

from caricli.geometry.components import mesh_components
from caricli.geometry.weighted_similarities import weighted_similarities
from caricli.structures import Mesh, Part
from caricli.template.head import load_head
from caricli.template.head_parts import head_parts
from caricli.template.template import Template

AROUND = 0.03
"""Of the head's height: how far around a part its surroundings say where it is."""

RIGID = 0.004
"""Of the head's height: what moves so much otherwise than the bone says half as much of it."""

NEIGHBOURS = 14
"""Vertices of a lid that a lash is held by."""


class Attachment:
    """What holds parts of a template in any face of its topology, prepared once."""

    def __init__(self, template: Template, parts: Sequence[Part]) -> None:
        """template: the head without expression. parts: in its shape, with what its expressions do to them."""
        self.holds = [
            _Lids(template, part) if part.hangs_on == "lids" else _Bone(template, part, parts) for part in parts
        ]

    def attach(self, mesh: Mesh) -> tuple[Part, ...]:
        """The parts of a face, without expressions. mesh: Mesh of its skin, metres, in the template's topology."""
        return self.animate(mesh, (), np.zeros((0, *mesh.vertices.shape)))

    def animate(self, mesh: Mesh, names: Sequence[str], deltas: np.ndarray) -> tuple[Part, ...]:
        """The parts of a face with expressions.

        mesh: Mesh of its skin, metres, in the template's topology. names: K. deltas: (K, V, 3) metres, what the
        expressions do to the skin.
        """
        neutral = np.asarray(mesh.vertices, float)
        return tuple(hold.place(neutral, tuple(names), deltas) for hold in self.holds)


def attachment_for(template: Template) -> Attachment | None:
    """The Attachment of a template's own parts, or of the open head's where it has its topology, else None."""
    if template.parts:
        return _own_attachment(template)
    return open_head_attachment() if template.topology_id == open_head_topology() else None


@lru_cache(maxsize=4)
def _own_attachment(template: Template) -> Attachment:
    return Attachment(template, template.parts)


@cache
def open_head_attachment() -> Attachment:
    """Of the open head in its usual shape."""
    head = load_head()
    return Attachment(head.template(), head_parts(head))


@cache
def open_head_topology() -> str:
    """The topology of the open head."""
    return load_head().template().topology_id


class _Bone:
    """A part that is as rigid as bone: it stands by a similarity of what surrounds it and moves by the jaw's."""

    def __init__(self, template: Template, part: Part, parts: Sequence[Part]) -> None:
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.template = np.asarray(template.vertices, float)
        distance = cKDTree(self.shape).query(self.template)[0]
        self.around = _anchors(np.exp(-0.5 * (distance / (AROUND * template.height)) ** 2))
        self.jaw = None if part.hangs_on == "skull" else _jaw_anchors(template, parts)

    def place(self, neutral: np.ndarray, names: tuple[str, ...], deltas: np.ndarray) -> Part:
        ids, weights = self.around
        scale, rotation, shift = weighted_similarities(self.template[ids], neutral[ids], weights)
        shape = scale * self.shape @ rotation.T + shift
        moved = np.zeros((len(names), *shape.shape))
        if self.jaw is not None and len(names):
            ids, weights = self.jaw
            start = neutral[ids]
            _, turns, shifts = weighted_similarities(start, start + deltas[:, ids], weights, scaling=False)
            moved = shape @ np.swapaxes(turns, -1, -2) + shifts[:, None] - shape
        for k, name in enumerate(names):
            if name == "tongueOut" and name in self.part.names:
                moved[k] += scale * self.part.deltas[self.part.names.index(name)] @ rotation.T
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=names, deltas=moved)


class _Lids:
    """Lashes, each held by the lid around its root."""

    def __init__(self, template: Template, part: Part) -> None:
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.template = np.asarray(template.vertices, float)
        self.labels = mesh_components(self.shape, part.mesh.faces).labels
        lids = np.flatnonzero(
            template.mask("eyes_left", "eyes_right") & ~template.mask("eye_socket_left", "eye_socket_right")
        )
        tree = cKDTree(self.template[lids])
        distance, _ = tree.query(self.shape)
        lashes = [np.flatnonzero(self.labels == k) for k in range(self.labels.max() + 1)]
        roots = self.shape[[ids[distance[ids].argmin()] for ids in lashes]]
        distance, near = tree.query(roots, NEIGHBOURS)
        self.ids = lids[near]
        self.weights = np.exp(-0.5 * (distance / distance.mean(1, keepdims=True)) ** 2)

    def place(self, neutral: np.ndarray, names: tuple[str, ...], deltas: np.ndarray) -> Part:
        shape = self._moved(self.template, neutral[None], self.shape, True)[0]
        moved = self._moved(neutral, neutral + deltas, shape, False) - shape
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=names, deltas=moved)

    def _moved(self, before: np.ndarray, after: np.ndarray, shape: np.ndarray, scaling: bool) -> np.ndarray:
        scale, rotation, shift = weighted_similarities(before[self.ids], after[:, self.ids], self.weights, scaling)
        turned = np.einsum("kwij,wj->kwi", rotation[:, self.labels], shape)
        return scale[:, self.labels, None] * turned + shift[:, self.labels]


def _anchors(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    ids = np.flatnonzero(weights > 1e-3 * weights.max())
    return ids, weights[ids]


def _jaw_anchors(template: Template, parts: Sequence[Part]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the skin that move as the jaw's bone does in every expression of the open head."""
    actions = load_head().actions.astype(float)
    bone = next(part for part in parts if part.name == "teeth_lower")
    start = np.asarray(bone.mesh.vertices, float)
    vertices = np.asarray(template.vertices, float)
    weights = np.ones(start.shape[0])
    _, turns, shifts = weighted_similarities(start, start + bone.deltas, weights, scaling=False)
    with_bone = vertices @ np.swapaxes(turns, -1, -2) + shifts[:, None] - vertices
    apart = np.sqrt(((actions - with_bone) ** 2).sum(-1).max(0))
    return _anchors(1 / (1 + (apart / (RIGID * template.height)) ** 4))
