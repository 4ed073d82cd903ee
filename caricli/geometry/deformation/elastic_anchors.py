"""Soft position constraints that bring their surroundings along."""

from collections.abc import Mapping

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import BOND, mesh_components

STIFFNESS_LENGTH = 0.04
"""Of the head's height: how far bending stiffness reaches around an anchor, about 1 cm."""

SPREAD_LENGTH = 0.02
"""Of the head's height: over how much of its surroundings the force on an anchor is spread, about 5 mm."""

_HOLD = 1e-9  # of the mean diagonal: makes the system definite, which knows no translation


class ElasticAnchors:
    """Moves of a few points carried to a whole surface, with everything factored once.

    The correction d of a shape minimises ``d^T (L + l^2 L M^-1 L) d + sum_k w_k |(C d)_k - m_k|^2``: a membrane
    (cotangent Laplacian L) with the bending stiffness of a plate (M the mass matrix, l ``STIFFNESS_LENGTH`` of the
    head's height), so that a pulled point does not become a spike. Row k of C averages the surroundings of point k
    (``SPREAD_LENGTH`` of the height), so that the force on it is spread as well. By Woodbury's identity a solve costs
    one small dense system for any subset of the prepared points. A common translation is free. Components without
    points of their own are taken along by their bonds (``mesh_components``).
    """

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        points: np.ndarray,
        solved: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        """vertices: (V, 3) template. faces: (F, 3). points: (K,) vertex ids that can be anchors, without repeats.
        solved: what ``solved`` was of anchors of the same, where there were some, so that nothing has to be factored.
        """
        self.points = np.asarray(points)
        self.rows = {int(p): k for k, p in enumerate(self.points)}
        laplacian = -igl.cotmatrix(vertices, faces)
        self.stiffness = laplacian.diagonal().mean()
        self.solved = _solve(vertices, faces, self.points, laplacian) if solved is None else solved
        self.responses = self.solved["responses"]
        self.compliance = self.solved["compliance"]

    def move(
        self, points: np.ndarray, moves: np.ndarray, strength: float, confidence: np.ndarray | None = None
    ) -> np.ndarray:
        """The smoothest displacement field in which the points make their moves.

        points: (K,) vertex ids among the prepared ones. moves: (K, n) metres along n axes. strength: weight of the
        points against the surface; large means exact. confidence: (K,) in (0, 1], relative weight of every point,
        or (K, n, n), symmetric and positive definite, of its directions.
        Returns (V, n) displacements.
        """
        if confidence is not None and confidence.ndim > 1:
            return self._move_along(points, moves, strength * confidence)
        chosen = np.array([self.rows[int(p)] for p in points])
        weight = strength * self.stiffness * (np.ones(len(chosen)) if confidence is None else confidence)
        count = len(chosen)
        system = np.ones((count + 1, count + 1))
        system[:count, :count] = self.compliance[np.ix_(chosen, chosen)] + np.diag(1 / weight)
        system[count, count] = 0.0
        solution = np.linalg.solve(system, np.vstack([moves, np.zeros((1, moves.shape[1]))]))
        return self.responses[:, chosen] @ solution[:count] + solution[count]

    def _move_along(self, points: np.ndarray, moves: np.ndarray, strength: np.ndarray) -> np.ndarray:
        """``move`` with a strength (K, n, n) of its own for every point, by its directions."""
        chosen = np.array([self.rows[int(p)] for p in points])
        count, axes = moves.shape
        identity = np.eye(axes)
        system = np.zeros((count + 1, axes, count + 1, axes))
        system[:count, :, :count] = np.einsum("kl,ab->kalb", self.compliance[np.ix_(chosen, chosen)], identity)
        system[range(count), :, range(count)] += np.linalg.inv(self.stiffness * strength)
        system[:count, :, count] = identity
        system[count, :, :count] = identity[:, None]
        right = np.vstack([moves, np.zeros((1, axes))]).ravel()
        solution = np.linalg.solve(system.reshape(right.size, right.size), right).reshape(count + 1, axes)
        return self.responses[:, chosen] @ solution[:count] + solution[count]


def _solve(
    vertices: np.ndarray, faces: np.ndarray, points: np.ndarray, laplacian: sp.csc_matrix
) -> dict[str, np.ndarray]:
    """How a surface moves under a unit force on each of the points: responses (V, K), and compliance (K, K), of the
    points' own surroundings. laplacian: (V, V) sparse."""
    stiffness = laplacian.diagonal().mean()
    bonds = BOND * stiffness * mesh_components(vertices, faces).stiffness(points)
    plate = bending_stiffness(vertices, faces, laplacian)
    factor = Cholesky(laplacian + plate + _HOLD * stiffness * sp.identity(len(vertices)) + bonds)
    mass = igl.massmatrix(vertices, faces).diagonal()
    averages = surrounding_averages(vertices, faces, points)
    responses = factor.solve(averages.T - mass[:, None] / mass.sum())
    responses -= mass @ responses / mass.sum()
    return {"responses": responses, "compliance": averages @ responses}


def bending_stiffness(vertices: np.ndarray, faces: np.ndarray, laplacian: sp.csc_matrix) -> sp.csc_matrix:
    """(V, V) sparse: ``l^2 L M^-1 L`` of ``ElasticAnchors``. laplacian: L of the vertices (V, 3) and faces (F, 3)."""
    mass = igl.massmatrix(vertices, faces).diagonal()
    return (STIFFNESS_LENGTH * np.ptp(vertices[:, 1])) ** 2 * laplacian @ sp.diags(1 / mass) @ laplacian


def surrounding_averages(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(K, V) weights by which the surroundings of points (K,) are averaged, those of each with the sum one.

    Diffusion for the time l^2 / 2 (l ``SPREAD_LENGTH`` of the height) spreads a point over its surroundings along the
    surface, never across a gap. vertices: (V, 3). faces: (F, 3).
    """
    mass = igl.massmatrix(vertices, faces).diagonal()
    time = (SPREAD_LENGTH * np.ptp(vertices[:, 1])) ** 2 / 2
    heat = Cholesky(sp.diags(mass) - time * igl.cotmatrix(vertices, faces))
    sources = np.zeros((len(vertices), len(points)))
    sources[points, np.arange(len(points))] = 1
    spread = heat.solve(sources) * mass[:, None]
    return (spread / spread.sum(0)).T
