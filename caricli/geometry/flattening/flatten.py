"""A surface in the plane, its triangles as nearly as possible of the sizes that they are to have."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.flattening.triangle_stretch import inverse_edges, plane_maps

_ROUNDS = 60
_ENOUGH = 1e-5  # relative gain of a round below which no more are made
_BACK = 0.8  # of the step with which the first triangle would lose its area
_DAMPING = 1e-9  # of the mean stiffness of a vertex
_SHORTEST = 1e-8  # of a step


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface to be flattened.

    vertices: (V, 3). faces: (F, 3), none without area. sizes: (V,) lengths in the plane for a length on the surface.
    weights: (F,) how much a triangle counts, for its area. shapes: (F, 3, 3) corners of the triangles where these are
    not of the shapes that the vertices give them; None where all are.
    """

    vertices: np.ndarray
    faces: np.ndarray
    sizes: np.ndarray
    weights: np.ndarray
    shapes: np.ndarray | None = None

    def inverse_edges(self) -> np.ndarray:
        """(F, 2, 2) as `inverse_edges` has them, of the triangles of the right sizes."""
        corners = self.vertices[self.faces] if self.shapes is None else self.shapes
        inverse = inverse_edges(corners.reshape(-1, 3), np.arange(self.faces.size).reshape(-1, 3))
        return inverse / self.sizes[self.faces].mean(1)[:, None, None]


@dataclass(frozen=True, eq=False)
class Limits:
    """Straight lines that a chart, mirror-symmetric about x = 0, is to stay behind.

    lines: (H, 3) rows a, b, c of ``a |x| + b y <= c``, with a² + b² = 1. strength: of the penalty.
    """

    lines: np.ndarray
    strength: float


def flatten(sheet: Sheet, start: np.ndarray, limits: Limits | None = None) -> np.ndarray:
    """Minimise ``sum w (|J|² + |J⁻¹|²) + strength sum max(0, a|x| + by - c)²`` by reweighted rigid fits.

    J is the map of a triangle over its size, so its energy is least, 4, where the map is a rotation, and infinite where
    the triangle loses its area: what starts without flipped triangles stays so (symmetric Dirichlet energy; Rabinovich
    et al. 2017, Scalable Locally Injective Mappings). The weights w sum to one. libigl's SLIM knows neither sizes nor
    limits.

    sheet: Sheet. start: (V, 2), no triangle flipped. limits: Limits, or None.
    Returns (V, 2).
    """
    problem = _Problem(sheet, np.sign(np.round(start[:, 0], 9)), limits)
    places = start
    energy = problem.energy(places)
    assert np.isfinite(energy), "flattening starts without flipped triangles"
    for _ in range(_ROUNDS):
        direction = problem.target(places) - places
        step = min(1.0, _BACK * problem.first_collapse(places, direction))
        while problem.energy(places + step * direction) >= energy and step > _SHORTEST:
            step /= 2
        lower = problem.energy(places + step * direction)
        if lower >= energy:
            break
        places = places + step * direction
        gain = (energy - lower) / energy
        energy = lower
        if gain < _ENOUGH:
            break
    return places


class _Problem:
    """The energy of a sheet's places, and the quadratic one that touches it."""

    def __init__(self, sheet: Sheet, side: np.ndarray, limits: Limits | None) -> None:
        faces = sheet.faces
        self.faces = faces
        self.inverse = sheet.inverse_edges()
        areas = 1 / np.linalg.det(self.inverse)
        self.weights = sheet.weights * areas / (sheet.weights * areas).sum()
        self.side = side
        self.lines = np.zeros((0, 3)) if limits is None else limits.lines
        self.strength = 0.0 if limits is None else limits.strength
        slopes = np.concatenate([-self.inverse.sum(1, keepdims=True), self.inverse], axis=1)
        rows = np.repeat(np.arange(len(faces)), 3)
        shape = (len(faces), len(side))
        self.slopes = [sp.csr_matrix((slopes[:, :, k].ravel(), (rows, faces.ravel())), shape) for k in (0, 1)]

    def energy(self, places: np.ndarray) -> float:
        maps = plane_maps(self.inverse, self.faces, places)
        areas = np.linalg.det(maps)
        if (areas <= 0).any():
            return float("inf")
        lengths = (maps**2).sum((1, 2))
        beyond = np.maximum(self._beyond(places), 0)
        return float((self.weights * (lengths + lengths / areas**2)).sum() + self.strength * (beyond**2).sum())

    def target(self, places: np.ndarray) -> np.ndarray:
        """(V, 2) where the quadratic energy is least that has the slope of the true one at the places."""
        count = len(places)
        turn, stretch, back = np.linalg.svd(plane_maps(self.inverse, self.faces, places))
        near = np.abs(stretch - 1) < 1e-4
        pull = np.sqrt(np.where(near, 4.0, (stretch - stretch**-3) / np.where(near, 1.0, stretch - 1)))
        pull = np.sqrt(self.weights)[:, None, None] * np.einsum("fij,fj,fkj->fik", turn, pull, turn)
        wanted = pull @ (turn @ back)
        rows = [sp.hstack([sp.diags(pull[:, i, k]) @ self.slopes[j] for k in (0, 1)]) for i in (0, 1) for j in (0, 1)]
        fit = sp.vstack(rows).tocsr()
        held, bounds = self._held(places)
        matrix = fit.T @ fit + self.strength * held.T @ held
        # What only turns or moves everything costs nothing.
        damping = _DAMPING * float(matrix.diagonal().mean())
        right = fit.T @ wanted.reshape(-1, 4).T.ravel() + self.strength * held.T @ bounds + damping * places.T.ravel()
        matrix = matrix + damping * sp.identity(2 * count)
        return Cholesky(matrix).solve(right[:, None])[:, 0].reshape(2, count).T

    def _held(self, places: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
        """Rows (H, 2 V) that say how far along the normals of lines what is beyond them is, and where the lines are."""
        vertex, line = np.nonzero(self._beyond(places) > 0)
        entries = np.concatenate([self.lines[line, 0] * self.side[vertex], self.lines[line, 1]])
        row = np.tile(np.arange(len(line)), 2)
        column = np.concatenate([vertex, vertex + len(places)])
        return sp.csr_matrix((entries, (row, column)), (len(line), 2 * len(places))), self.lines[line, 2]

    def first_collapse(self, places: np.ndarray, direction: np.ndarray) -> float:
        """The smallest step in a direction (V, 2) with which a triangle loses its area."""
        edges, moves = (a[self.faces[:, 1:]] - a[self.faces[:, :1]] for a in (places, direction))
        constant = np.linalg.det(edges)
        square = np.linalg.det(moves)
        linear = np.linalg.det(edges + moves) - constant - square
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(linear**2 - 4 * square * constant)
            steps = np.stack([2 * constant / (-linear + root), 2 * constant / (-linear - root)])
        return float(np.min(steps, where=steps > 0, initial=np.inf))

    def _beyond(self, places: np.ndarray) -> np.ndarray:
        """(V, H) how far places are beyond the lines."""
        mirrored = np.stack([self.side * places[:, 0], places[:, 1]], axis=1)
        return mirrored @ self.lines[:, :2].T - self.lines[:, 2]
