"""Laplacian deformation: a few anchors move, and the surface between them keeps its local shape."""

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import BOND, mesh_components
from caricli.geometry.vertex_neighbours import vertex_neighbours

ROUNDS = 4
"""Estimates of the rotations."""

_LEAST = 1e-2  # of the usual cotangent weight: with less the mean of neighbours could lie anywhere


class LaplacianDeformation:
    """Vertices of least ``sum_i |L(v)_i - R_i L(v_0)_i|^2 + w sum_k |v_k - p_k|^2`` (portrait paper, (10)).

    L(v)_i is what sets vertex i apart from the mean of its neighbours (eq. 9), R_i the rotation of its one-ring, which
    the paper leaves out: without it large corrections shear and shrink what stands out. Solution and rotations are
    found in turns (Sorkine and Alexa 2007), with one factorisation: not of L^T L, but of S = D L with D the sums of the
    weights, which is symmetric and has a third of the entries. With l_i the turned detail, the least has
    S v = D l + D^2 u and S u = P^T w (p - P v), P picking the anchors; S + P^T P is positive definite, and what P^T P
    adds is settled exactly among the anchors. Components without anchors are then solved for alone, as their bonds to
    the largest one pull at them (``mesh_components``).
    """

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        anchors: np.ndarray,
        weight: float,
        laplacian: str = "cotangent",
    ) -> None:
        """Factor the system. Raises NumericsError for triangles without area.

        vertices: (V, 3). faces: (F, 3). anchors: (K,) distinct ids. weight: of an anchor against a vertex. laplacian:
        "uniform", every neighbour counts the same, as published, or "cotangent".
        """
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.anchors = np.asarray(anchors)
        self.weight = weight
        count = len(vertices)
        order = np.arange(len(self.anchors))
        weights, _ = vertex_neighbours(faces, count)
        if laplacian == "cotangent":
            cotangents = igl.cotmatrix(self.vertices, faces)
            if not np.isfinite(cotangents.data).all():
                raise NumericsError("expected triangles with an area, found some without")
            usual = np.median(cotangents.data[cotangents.data > 0])
            weights = weights.multiply(cotangents).tocsr()
            weights.data = np.clip(weights.data, _LEAST * usual, None)
        self.degrees = weights @ np.ones((count, 1))
        stiffness = sp.diags(self.degrees[:, 0]) - weights
        self.detail = stiffness @ self.vertices / self.degrees
        self.pick = sp.csr_matrix((np.ones(len(order)), (order, self.anchors)), (len(order), count))
        bond = BOND * np.median(weights.data)
        own, self.hold = (bond * pull for pull in mesh_components(self.vertices, faces).pull(self.anchors))
        self._factor = Cholesky(stiffness + own + self.pick.T @ self.pick)
        self.responses = self._factor.solve(self.pick.T.toarray())
        free = np.identity(len(order)) - self.responses[self.anchors]
        bending = (self.degrees * self.responses).T @ (self.degrees * self.responses)
        self.among = np.block([[free, weight * np.identity(len(order))], [-bending, free]])
        # Of edges turned: sum_j w_ij (v0_i - v0_j) (v_i - v_j)^T, one coordinate of v0 after the other.
        edges = [sp.diags(column) @ weights - weights @ sp.diags(column) for column in self.vertices.T]
        self.rings = sp.vstack([sp.diags(np.asarray(edge.sum(1)).ravel()) - edge for edge in edges]).tocsr()

    def move(self, targets: np.ndarray, rounds: int = ROUNDS) -> np.ndarray:
        """Vertices with the anchors at their targets, nearly.

        targets: (K, 3). rounds: how often the rotations are estimated; 0 keeps every R_i at one.
        Returns (V, 3).
        """
        moved = self._least(self.detail, targets)
        for _ in range(rounds):
            rotations = igl.fit_rotations(self.rings @ moved).reshape(3, -1, 3)
            moved = self._least(np.einsum("avb,vb->va", rotations, self.detail), targets)
        return moved

    def influence(self) -> np.ndarray:
        """(V, K) how far every vertex goes by one anchor's move of one, while the others stay and nothing turns."""
        return self._least(np.zeros_like(self.responses), np.identity(len(self.anchors)))

    def _least(self, detail: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Vertices (V, n) of least energy for turned detail (V, n) and targets (K, n)."""
        pull = self.degrees * detail
        right = np.concatenate([self.weight * targets, self.responses.T @ pull])
        forces, places = np.split(np.linalg.solve(self.among, right), 2)
        moved = self._factor.solve(pull + self.degrees**2 * (self.responses @ forces) + self.pick.T @ places)
        return moved - self._factor.solve(self.hold @ moved) if self.hold.nnz else moved
