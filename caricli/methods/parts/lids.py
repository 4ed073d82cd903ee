"""Lashes that stand on the edges of lids."""

from dataclasses import replace

import numpy as np

from caricli.geometry.components import component_labels
from caricli.geometry.weighted_similarities import weighted_similarities
from caricli.io.kept import kept_arrays
from caricli.methods.parts.bones import Posed
from caricli.methods.parts.pocket import spread
from caricli.structures import Part
from caricli.template.template import Template

NEIGHBOURS = 6
"""Vertices of a lid that a lash is held by."""


class Lids:
    """Lashes, each held by the lid around its root."""

    def __init__(self, template: Template, part: Part) -> None:
        """template: whose annotation knows the eyes. part: a component of its mesh for every lash."""
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.template = np.asarray(template.vertices, float)
        self.labels = component_labels(part.mesh.faces, len(self.shape))
        lids = np.flatnonzero(
            template.mask("eyes_left", "eyes_right") & ~template.mask("eye_socket_left", "eye_socket_right")
        )
        given = (self.template[lids], self.shape, self.labels)
        held = kept_arrays("lids", given, lambda: _held(*given))
        self.roots = held["roots"]
        self.ids = lids[held["near"]]
        distance = held["distance"]
        self.weights = np.exp(-0.5 * (distance / distance.mean(1, keepdims=True)) ** 2)

    def place(self, face: Posed) -> Part:
        """The lashes of a face."""
        size = spread(face.neutral) / spread(self.template)
        shape = self._shortened(self._moved(self.template, face.neutral[None], self.shape, True)[0], size)
        moved = self._moved(face.neutral, face.neutral + face.deltas, shape, False) - shape
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=face.names, deltas=moved)

    def _shortened(self, shape: np.ndarray, size: float) -> np.ndarray:
        """Lashes that are no longer than those of usual eyes on a head of a size: drawn eyes are often huge."""
        roots = shape[self.roots][self.labels]
        away = shape - roots
        length = _lengths(away, self.labels) / _lengths(self.shape - self.shape[self.roots][self.labels], self.labels)
        return roots + away / np.maximum(length / size, 1.0)[self.labels, None]

    def _moved(self, before: np.ndarray, after: np.ndarray, shape: np.ndarray, scaling: bool) -> np.ndarray:
        scale, rotation, shift = weighted_similarities(before[self.ids], after[:, self.ids], self.weights, scaling)
        turned = np.einsum("kwij,wj->kwi", rotation[:, self.labels], shape)
        return scale[:, self.labels, None] * turned + shift[:, self.labels]


def _held(lids: np.ndarray, shape: np.ndarray, labels: np.ndarray) -> dict[str, np.ndarray]:
    """The root of every lash, and of vertices of lids (N, 3) the numbers of those near it and their distances.

    shape: (W, 3) of the lashes. labels: (W,) the lash of every vertex, from 0 to L - 1. Roots: (L,); the rest: (L, k).
    """
    # Imported here: it takes longer than all of this, which is mostly kept.
    from scipy.spatial import cKDTree

    tree = cKDTree(lids)
    distance, _ = tree.query(shape)
    lashes = [np.flatnonzero(labels == k) for k in range(labels.max() + 1)]
    roots = np.array([ids[distance[ids].argmin()] for ids in lashes])
    distance, near = tree.query(shape[roots], min(NEIGHBOURS, len(lids)))
    return {"roots": roots, "near": near, "distance": distance}


def _lengths(away: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """(L,) how far the farthest vertex of every lash is from its root. away: (W, 3) from there. labels: (W,)."""
    lengths = np.zeros(labels.max() + 1)
    np.maximum.at(lengths, labels, np.linalg.norm(away, axis=1))
    return lengths
