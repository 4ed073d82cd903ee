"""Mouth cavity and eye sockets kept behind the skin."""

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import component_labels
from caricli.geometry.triangle_normals import triangle_normals

TOUCH = 0.006
"""Of the head's height: a pocket nearer to the skin than this shows through it in pictures."""

MARGIN = 0.02
"""Of the head's height: as far inside a pocket is put that has to move."""

ROUNDS = 10
"""Moves, at most: the membrane smooths each, so that one alone does not reach the margin."""

RIM_RINGS = 2
"""Edges around a rim, where pocket and skin touch by their nature, and cross where lips meet."""

_JUST = 0.25  # of TOUCH: as far behind the skin goes what came out near a rim; farther, thin lining folds
_CLEARLY = 0.3  # cosine to a vertex's normal from which on a point is surely on its other side
_PULL = 1e3  # of the membrane's mean diagonal: what has to move moves as far as it has to

Solid = tuple[np.ndarray, np.ndarray]
"""Vertices and faces of the closed skin, see ``Cavities.closed``."""


@dataclass(frozen=True, eq=False)
class Pocket:
    """One cavity. edges: (E, 2) of its rim. free: ids of the vertices inside. spots: (P, V) sparse, weights of these
    vertices and of the middles of its triangles. deep: (P,) bool, vertices far from the rim. laplacian: sparse, of the
    free ones."""

    edges: np.ndarray
    free: np.ndarray
    spots: sp.csr_matrix
    deep: np.ndarray
    laplacian: sp.csc_matrix


class Cavities:
    """The pockets of a head, which no landmark holds and which a flattened face would push through the skin.

    The skin is their component, without the pockets, each opening closed by a fan. A pocket with a spot outside the
    skin (generalised winding number below one half) or a vertex nearer to it than ``TOUCH`` of the height is moved
    inwards until all its vertices keep a distance of ``MARGIN``, as a membrane whose rim stays. Its vertices near the
    rim and the middles of its triangles only follow, but where they came out through skin that is not at the rim:
    then they go just behind it.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, regions: Sequence[np.ndarray]) -> None:
        """vertices: (V, 3) template. faces: (F, 3). regions: lists of vertex ids, one for each pocket."""
        height = np.ptp(vertices[:, 1])
        self.touch = TOUCH * height
        self.margin = MARGIN * height
        self.pockets: list[Pocket] = []
        inside = np.zeros(len(faces), dtype=bool)
        for region in regions:
            member = np.zeros(len(vertices), dtype=bool)
            member[region] = True
            own = member[faces].all(axis=1)
            inside |= own
            if len(igl.boundary_facets(faces[own])[0]):
                self.pockets.append(_pocket(vertices, faces[own]))
        # Eyes and teeth lie in the pockets as they should.
        labels = component_labels(faces, len(vertices))
        own = np.isin(labels[faces[:, 0]], labels[faces[inside, 0]])
        self.skin = faces[own & ~inside]
        near = np.zeros(len(vertices), dtype=bool)
        for pocket in self.pockets:
            near |= _around(pocket.edges, self.skin, len(vertices))
        self.at_rim = near[self.skin].any(axis=1)

    def tuck(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with all pockets inside."""
        return self._pulled(vertices, self.touch, (self.margin, _JUST * self.touch))

    def withdraw(self, vertices: np.ndarray, asked: np.ndarray | None = None, solid: Solid | None = None) -> np.ndarray:
        """Vertices (V, 3) with what came through the skin behind it again, and all else of the pockets as near to it as
        it was, but for what goes along. asked: (P,) bool, spots of all pockets that may have come out, or None. solid:
        what ``closed`` gives of the vertices, where that was asked before, or None."""
        return self._pulled(vertices, 0.0, (0.0, self.touch), asked, solid)

    def _pulled(
        self,
        vertices: np.ndarray,
        allowed: float,
        required: tuple[float, float],
        asked: np.ndarray | None = None,
        solid: Solid | None = None,
    ) -> np.ndarray:
        """Vertices (V, 3) whose pockets with vertices nearer to the skin than allowed are farther than required: far
        from the rim, and where they came out. asked: (P,) bool, or None, of the spots that are looked at first. solid:
        as of ``withdraw``."""
        vertices = np.array(vertices)
        solid = self.closed(vertices) if solid is None else solid
        moves = self._moves(solid, self.pockets, (allowed, required[1]), asked)
        pockets = [pocket for pocket, move in zip(self.pockets, moves, strict=True) if move.any()]
        for _ in range(ROUNDS):
            if not pockets:
                break
            moves = self._moves(self.closed(vertices), pockets, required)
            for pocket, move in zip(pockets, moves, strict=True):
                weights = pocket.spots[:, pocket.free]
                pull = weights.T @ sp.diags(_PULL * pocket.laplacian.diagonal().mean() * move.any(axis=1))
                vertices[pocket.free] += Cholesky(pocket.laplacian + pull @ weights).solve(pull @ move)
            pockets = [pocket for pocket, move in zip(pockets, moves, strict=True) if move.any()]
        return vertices

    def _moves(
        self,
        solid: Solid,
        pockets: Sequence[Pocket],
        required: tuple[float, float],
        asked: np.ndarray | None = None,
    ) -> list[np.ndarray]:
        """For each pocket (P, 3): how far its spots must go to be inside the skin by the required distances. asked:
        (P,) bool, or None, of the spots of all pockets that are looked at."""
        if not pockets:
            return []
        closed = solid[0]
        points = np.concatenate([pocket.spots @ closed[: pocket.spots.shape[1]] for pocket in pockets])
        deep = np.concatenate([pocket.deep for pocket in pockets])
        moves = np.zeros_like(points)
        looked = np.arange(len(points)) if asked is None else np.flatnonzero(asked)
        if not required[0]:
            looked = looked[self._may_be_out(closed, points[looked])]
        if len(looked):
            moves[looked] = self._inwards(points[looked], deep[looked], solid, required)
        return np.split(moves, np.cumsum([len(pocket.deep) for pocket in pockets])[:-1])

    def _may_be_out(self, vertices: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(P,) bool: points (P, 3) that do not clearly lie behind the nearest vertex of the skin, which is found
        quickly."""
        skin = np.unique(self.skin)
        normals = igl.per_vertex_normals(vertices, self.skin)[skin]
        gaps, nearest = KDTree(vertices[skin]).query(points)
        return ((points - vertices[skin][nearest]) * normals[nearest]).sum(1) > -_CLEARLY * gaps

    def _inwards(self, points: np.ndarray, deep: np.ndarray, solid: Solid, required: tuple[float, float]) -> np.ndarray:
        """(P, 3) how far points (P, 3) must go. deep: (P,) bool."""
        closed, surface = solid
        squared, face, nearest = igl.point_mesh_squared_distance(points, closed, self.skin)
        distance = np.sqrt(squared)
        away = points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, the winding number decides.
        outside = (triangle_normals(closed, self.skin)[face] * away).sum(1) > 0
        outside &= deep | ~self.at_rim[face]
        if outside.any():
            outside[outside] = igl.fast_winding_number(closed, surface, points[outside]) < 0.5
        short = np.where(deep, np.maximum(required[0] - distance, 0), 0)
        behind = np.where(deep, max(required), required[1])
        missing = np.where(outside, distance + behind, short)
        signs = np.where(outside, -1.0, 1.0)
        return (signs * missing / np.maximum(distance, 1e-9))[:, None] * away

    def closed(self, vertices: np.ndarray) -> Solid:
        """Vertices (V, 3) with the middles of the openings appended, and the skin's faces with the fans."""
        closed = [vertices]
        fans = []
        for number, pocket in enumerate(self.pockets):
            edges = pocket.edges
            closed.append(vertices[np.unique(edges)].mean(0, keepdims=True))
            # The pocket's boundary runs as the pocket sees it, which is the direction that the cap needs.
            fans.append(np.column_stack([edges, np.full(len(edges), len(vertices) + number)]))
        return np.concatenate(closed), np.concatenate([self.skin, *fans])


def _pocket(vertices: np.ndarray, faces: np.ndarray) -> Pocket:
    """The pocket of faces (F, 3), open as they are, in a template's vertices (V, 3)."""
    edges = igl.boundary_facets(faces)[0]
    rim = np.unique(edges)
    free = np.setdiff1d(np.unique(faces), rim)
    near = _around(edges, faces, len(vertices))
    laplacian = -igl.cotmatrix(vertices, faces)[free][:, free]
    corners = [np.column_stack([free, free]), igl.edges(faces), faces]
    spots = sp.vstack([_means(ids[~np.isin(ids, rim).all(axis=1)], len(vertices)) for ids in corners], format="csr")
    deep = np.zeros(spots.shape[0], dtype=bool)
    deep[: len(free)] = ~near[free]
    return Pocket(edges, free, spots, deep, laplacian)


def _around(edges: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """(count,) bool: vertices of edges (E, 2), and those of faces (F, 3) within ``RIM_RINGS`` of them."""
    near = np.zeros(count, dtype=bool)
    near[edges] = True
    for _ in range(RIM_RINGS):
        near[faces[near[faces].any(axis=1)]] = True
    return near


def _means(ids: np.ndarray, count: int) -> sp.csr_matrix:
    """Weights (N, count) of the means of vertices of ids (N, K)."""
    rows = np.arange(len(ids)).repeat(ids.shape[1])
    return sp.csr_matrix((np.full(ids.size, 1 / ids.shape[1]), (rows, ids.ravel())), shape=(len(ids), count))
