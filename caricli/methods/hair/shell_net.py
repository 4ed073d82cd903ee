"""The net of a shell of hair, whose vertices move around a head without folds."""

import numpy as np
import scipy.sparse as sp
from scipy.ndimage import label
from scipy.sparse.csgraph import connected_components

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.structures import Mesh

_LEAST = 0.05  # of its area at first: with less, as seen from the middle of the head, a triangle is folded
_RINGS = (1, 2, 3, 4, 6)  # of vertices around folds that are laid anew, farther where folds are left
_OWN = 1e-6  # weight of where a vertex is, beside one of its neighbours


class ShellNet:
    """Which vertices of a shell hang together, and where around the head they were at first.

    mean: (V, V) the operator that takes the mean of every vertex's neighbours.
    """

    def __init__(self, shell: Mesh, sphere: HeadSphere) -> None:
        """shell: as it was made, without folds. sphere: HeadSphere of the head that it is on."""
        self.faces = shell.faces
        # Around the whorl, which is the first vertex, there are as many in every ring.
        self.columns = int((shell.faces == 0).any(1).sum())
        self.adjacency, self.mean = vertex_neighbours(shell.faces, len(shell.vertices))
        longitudes, angles, _ = sphere.seen_from(shell.vertices)
        self.start = sphere.directions(longitudes, angles)
        self.areas = self._areas(self.start)

    def unfolded(self, points: np.ndarray, skin: HeadSphere) -> np.ndarray:
        """(V, 3) metres: the shell's vertices (V, 3) as far above the skin, without folds as seen from its middle.

        Where triangles that are above the skin have turned over, movements since the first places are laid anew between
        those of what is around them, as a membrane; farther around where this does not do.
        """
        longitudes, angles, radii = skin.seen_from(points)
        above = radii - skin.ground(longitudes, angles)
        directions = skin.directions(longitudes, angles)
        shown = (above > 0)[self.faces].any(1)
        for rings in _RINGS:
            folded = shown & (self._areas(directions) * self.areas < _LEAST * self.areas**2)
            if not folded.any():
                break
            directions = self._laid_anew(directions, self._around(self.faces[folded], rings))
        longitudes, angles, _ = skin.seen_from(skin.middle + directions)
        return skin.points(longitudes, angles, skin.ground(longitudes, angles) + above)

    def large_parts(self, chosen: np.ndarray, least: float = 1.0) -> np.ndarray:
        """(V,) bool: of vertices (V,) bool the most that hang together, and others that are so many times as many."""
        ids = np.flatnonzero(chosen)
        if not len(ids):
            return chosen
        _, parts = connected_components(self.adjacency[ids][:, ids], directed=False)
        counts = np.bincount(parts)
        large = np.zeros_like(chosen)
        large[ids[(counts >= least * counts.max())[parts]]] = True
        return large

    def without_strips(self, chosen: np.ndarray) -> np.ndarray:
        """(V,) bool: of vertices (V,) bool those within two edges of one all of whose neighbours are among them."""
        near = chosen & ~(self.adjacency @ ~chosen > 0)
        for _ in range(2):
            near = near | (self.adjacency @ near > 0)
        return chosen & near

    def out_again(self, above: np.ndarray, points: np.ndarray, length: float) -> np.ndarray:
        """(V,) bool: of vertices above the skin (V,) bool those that come out of it for less than a length, once the
        shell has gone under it on the way from the whorl. points: (V, 3) metres."""
        grid = above[1:].reshape(-1, self.columns)
        places = points[1:].reshape(*grid.shape, 3)
        steps = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=2)
        runs, count = label(grid, [[0, 1, 0]] * 3)
        lengths = np.bincount(runs.ravel(), (steps * grid).ravel(), count + 1)
        again = grid & ~np.logical_and.accumulate(grid, axis=0) & (lengths[runs] < length)
        return np.append(False, again)

    def _around(self, faces: np.ndarray, rings: int) -> np.ndarray:
        """(V,) bool: vertices of faces (F, 3), and so many rings, with these as the first, around them."""
        near = np.zeros(len(self.start), bool)
        near[faces] = True
        for _ in range(rings - 1):
            near |= self.adjacency @ near > 0
        return near

    def _laid_anew(self, directions: np.ndarray, loose: np.ndarray) -> np.ndarray:
        """(V, 3) directions, movements of loose ones (V,) bool the smoothest between those of the others."""
        moves = directions - self.start
        own, rest = np.flatnonzero(loose), np.flatnonzero(~loose)
        rows = self.adjacency[own]
        weights = sp.diags(np.asarray(rows.sum(1)).ravel() + _OWN) - rows[:, own]
        moves[own] = Cholesky(weights).solve(rows[:, rest] @ moves[rest] + _OWN * moves[own])
        laid = self.start + moves
        unit: np.ndarray = laid / np.linalg.norm(laid, axis=1, keepdims=True)
        return unit

    def _areas(self, directions: np.ndarray) -> np.ndarray:
        """(F,) areas of triangles of directions (V, 3), twice as large, below zero for what has turned over."""
        first, second, third = (directions[self.faces[:, k]] for k in range(3))
        areas: np.ndarray = np.einsum("fk,fk->f", np.cross(second - first, third - first), first)
        return areas
