"""Laplacian deformation: a few anchors move, and the surface between them keeps its local shape."""

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.vertex_neighbours import vertex_neighbours

ROUNDS = 4
_LEAST = 1e-2


class LaplacianDeformation:
    """Vertices of least ``sum_i |L(v)_i - R_i L(v_0)_i|^2 + w sum_k |v_k - p_k|^2`` (portrait paper, (10)).

    L(v)_i is what sets vertex i apart from the mean of its neighbours (eq. 9), R_i the rotation of its one-ring, which
    the paper leaves out: without it large corrections shear and shrink what stands out. Solution and rotations are
    found in turns (Sorkine and Alexa 2007), with one factorisation.
    """

    def __init__(self, vertices, faces, anchors, weight, laplacian="cotangent"):
        """Factor the system. Raises NumericsError for triangles without area.

        vertices: (V, 3). faces: (F, 3). anchors: (K,) distinct ids. weight: of an anchor against a vertex. laplacian:
        "uniform", every neighbour counts the same, as published, or "cotangent".
        """
        self.vertices, self.anchors = np.asarray(vertices, dtype=np.float64), np.asarray(anchors)
        count = len(vertices)
        adjacency, mean = vertex_neighbours(faces, count)
        if laplacian == "cotangent":
            cotangents = igl.cotmatrix(self.vertices, faces)
            if not np.isfinite(cotangents.data).all():
                raise NumericsError("expected triangles with an area, found some without")
            # Clipped far from zero, or the mean of neighbours could lie anywhere.
            usual = np.median(cotangents.data[cotangents.data > 0])
            weights = adjacency.multiply(cotangents).tocsr()
            weights.data = np.clip(weights.data, _LEAST * usual, None)
            mean = sp.diags(1 / np.asarray(weights.sum(1)).ravel()) @ weights
        mean = mean.tocoo()
        self.rows, self.columns, self.shares = mean.row, mean.col, mean.data
        self.laplacian = (sp.identity(count) - mean).tocsr()
        self.weight = np.zeros(count)
        self.weight[self.anchors] = weight
        self._factor = Cholesky(self.laplacian.T @ self.laplacian + sp.diags(self.weight))
        self.detail = self.laplacian @ self.vertices
        self.edges = self.shares[:, None] * (self.vertices[self.rows] - self.vertices[self.columns])

    def move(self, targets, rounds=ROUNDS):
        """Vertices (V, 3) with the anchors at their targets (K, 3), nearly.

        rounds: how often the rotations are estimated; 0 keeps every R_i at one.
        """
        places = np.array(self.vertices)
        places[self.anchors] = targets
        pulls = self.weight[:, None] * places
        moved = self._factor.solve(self.laplacian.T @ self.detail + pulls)
        for _ in range(rounds):
            turned = np.einsum("vab,vb->va", self._rotations(moved), self.detail)
            moved = self._factor.solve(self.laplacian.T @ turned + pulls)
        return moved

    def _rotations(self, moved):
        """(V, 3, 3) best rotations of the one-rings."""
        products = (self.edges[:, :, None] * (moved[self.rows] - moved[self.columns])[:, None, :]).reshape(-1, 9)
        sums = np.stack([np.bincount(self.rows, column, len(moved)) for column in products.T], axis=1)
        u, _, vt = np.linalg.svd(sums.reshape(-1, 3, 3))
        sign = np.ones((len(moved), 3))
        sign[:, 2] = np.linalg.det(u @ vt)
        return np.swapaxes((u * sign[:, None]) @ vt, 1, 2)
