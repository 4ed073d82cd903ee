"""The components of a mesh, and the weak bonds that let all others hang on the largest one."""

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.vertex_neighbours import vertex_neighbours

POINTS = 8
"""Of a component that are bound, spread over it."""

NEAREST = 12
SPREAD = 12
"""Vertices of the largest component that hold a point: the nearest, and others all over it, so that they are never in
one plane and the point follows every affine map."""

BOND = 0.1
"""Of a vertex's usual stiffness: eyes and teeth keep their shape, thin lashes follow their lid."""


@dataclass(frozen=True, eq=False)
class Components:
    """Which vertices hang together, and on what the others hang.

    labels: (V,) number of every vertex's component, 0 the one with most vertices.
    bonds: (R, V) sparse: points of the other components less the same points as vertices of the largest one around
    them make them; zero for the shape and all its affine images.
    owners: (R,) the component of every bond.
    """

    labels: np.ndarray
    bonds: sp.csr_matrix
    owners: np.ndarray

    @property
    def count(self) -> int:
        """How many components there are."""
        return int(self.labels.max()) + 1

    def stiffness(self, held: np.ndarray) -> sp.csr_matrix:
        """(V, V) sparse S with ``v^T S v = |bonds v|^2``, of the components that are not held.

        held: vertex ids that have their place.
        """
        loose = self._loose(held)
        return (loose.T @ loose).tocsr()

    def pull(self, held: np.ndarray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """How bonds pull at the components that are not held, while these do not pull at the largest one.

        In an energy that counts forces, not lengths, those at the largest one would turn the others into levers.
        held: vertex ids that have their place.
        Returns two (V, V) sparse matrices, which take vertices to forces, by those of the components themselves and by
        those of the largest one.
        """
        loose = self._loose(held)
        own = loose @ sp.diags((self.labels > 0).astype(float))
        return (own.T @ own).tocsr(), (own.T @ (loose - own)).tocsr()

    def _loose(self, held: np.ndarray) -> sp.csr_matrix:
        return self.bonds[~np.isin(self.owners, self.labels[held])]

    @cached_property
    def hangers(self) -> sp.csr_matrix:
        """(C - 1, V) sparse: the mean bond of every component but the first, which says where it is as a whole."""
        rows = np.arange(len(self.owners))
        bound = np.bincount(self.owners, minlength=self.count)[self.owners]
        mean = sp.csr_matrix((1 / bound, (self.owners - 1, rows)), (self.count - 1, len(rows)))
        return (mean @ self.bonds).tocsr()

    @cached_property
    def averages(self) -> sp.csr_matrix:
        """(C, V) sparse: the mean over every component."""
        sizes = np.bincount(self.labels)
        return sp.csr_matrix((1 / sizes[self.labels], (self.labels, np.arange(len(self.labels)))))

    def hang(self, vertices: np.ndarray, like: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) whose components hang on the first one as in a shape ``like`` (V, 3), the first unmoved."""
        missing = self.hangers @ (like - vertices)
        return vertices + np.concatenate([np.zeros((1, vertices.shape[1])), missing])[self.labels]

    def place(self, vertices: np.ndarray, means: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with every component moved to where its mean (C, 3) is to be."""
        return vertices + (means - self.averages @ vertices)[self.labels]

    def carry(self, moved: np.ndarray) -> np.ndarray:
        """Displacements (V, 3), of which only those of the first component count, the others taken along unturned."""
        first = np.where((self.labels == 0)[:, None], moved, 0.0)
        return self.hang(first, np.zeros_like(first))


def mesh_components(vertices: np.ndarray, faces: np.ndarray) -> Components:
    """The Components of a mesh.

    vertices: (V, 3). faces: (F, 3), every vertex in one.
    """
    count = len(vertices)
    labels = component_labels(faces, count)
    number = int(labels.max()) + 1
    if number == 1:
        return Components(labels, sp.csr_matrix((0, count)), np.zeros(0, int))
    largest = np.flatnonzero(labels == 0)
    points = [_spread(vertices, np.flatnonzero(labels == part), POINTS) for part in range(1, number)]
    owners = np.repeat(np.arange(1, number), [len(ids) for ids in points])
    ids = np.concatenate(points)
    columns, weights = _follow(vertices, ids, largest)
    rows = np.repeat(np.arange(len(ids)), columns.shape[1])
    bonds = sp.csr_matrix((-weights.ravel(), (rows, columns.ravel())), (len(ids), count))
    bonds += sp.csr_matrix((np.ones(len(ids)), (np.arange(len(ids)), ids)), (len(ids), count))
    return Components(labels, bonds.tocsr(), owners)


def component_labels(faces: np.ndarray, count: int) -> np.ndarray:
    """(V,) the number of every vertex's component, 0 the one with most vertices.

    faces: (F, 3). count: V, every vertex in a triangle.
    """
    parts = igl.vertex_components_from_adjacency_matrix(vertex_neighbours(faces, count)[0].astype(int))[0]
    # By size, those of one size by their first vertex: rounding cannot change it.
    order = np.argsort(-np.bincount(parts), kind="stable")
    return np.argsort(order)[parts]


def _follow(vertices: np.ndarray, ids: np.ndarray, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (R, K) of the largest component and their weights (R, K) that give the points of ids (R,).

    Least ``sum_k (w_k d_k)^2`` with ``sum_k w_k = 1`` and ``sum_k w_k v_k`` the point, d_k the distances.
    """
    # Imported here: it takes a while, and most heads are one component.
    from scipy.spatial import KDTree

    distance, near = KDTree(vertices[largest]).query(vertices[ids], min(NEAREST, len(largest)))
    far = _spread(vertices, largest, SPREAD)
    columns = np.concatenate([largest[near], np.tile(far, (len(ids), 1))], axis=1)
    offsets = vertices[columns] - vertices[ids][:, None]
    scale = distance.mean(1)[:, None, None]
    offsets = offsets / scale
    loose = 1 / (1 + (offsets**2).sum(2))
    conditions = np.concatenate([np.ones((*columns.shape, 1)), offsets], axis=2)
    gram = np.einsum("rki,rk,rkj->rij", conditions, loose, conditions)
    forces = np.linalg.pinv(gram, hermitian=True)[:, :, 0]
    return columns, loose * np.einsum("rki,ri->rk", conditions, forces)


def _spread(vertices: np.ndarray, ids: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the vertices ids (N,), each as far as can be from those before it."""
    points = vertices[ids]
    chosen = [int(((points - points.mean(0)) ** 2).sum(1).argmax())]
    distance = np.full(len(points), np.inf)
    for _ in range(min(count, len(ids)) - 1):
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(1))
        chosen.append(int(distance.argmax()))
    return ids[chosen]
