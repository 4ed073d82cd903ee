"""Mouth cavity and eye sockets kept behind the skin."""

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import component_labels
from caricli.geometry.triangle_normals import triangle_normals

TOUCH = 0.006
"""Of the head's height: a pocket nearer to the skin than this shows through it in pictures."""

MARGIN = 0.02
"""Of the head's height: as far inside a pocket is put that has to move."""

ROUNDS = 5
"""Moves, at most: the membrane smooths each, so that one alone does not reach the margin."""

RIM_RINGS = 2
"""Edges around a rim, where a pocket touches the skin by its nature."""

_PULL = 1e3  # of the membrane's mean diagonal: what has to move moves as far as it has to


@dataclass(frozen=True, eq=False)
class _Pocket:
    """One cavity. edges: (E, 2) of its rim. free: ids of the vertices inside. deep: of those far from the rim.
    laplacian: sparse, of the free ones."""

    edges: np.ndarray
    free: np.ndarray
    deep: np.ndarray
    laplacian: sp.csc_matrix


class Cavities:
    """The pockets of a head, which no landmark holds and which a flattened face would push through the skin.

    The skin is their component, without the pockets, each opening closed by a fan. A pocket with a vertex outside the
    skin (generalised winding number below one half) or nearer to it than ``TOUCH`` of the height is moved inwards until
    all its vertices keep a distance of ``MARGIN``, as a membrane whose rim stays; near the rim, where a pocket
    touches the skin by its nature, it only follows.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, regions: Sequence[np.ndarray]) -> None:
        """vertices: (V, 3) template. faces: (F, 3). regions: lists of vertex ids, one for each pocket."""
        height = np.ptp(vertices[:, 1])
        self.touch = TOUCH * height
        self.margin = MARGIN * height
        self.pockets: list[_Pocket] = []
        inside = np.zeros(len(faces), dtype=bool)
        for region in regions:
            member = np.zeros(len(vertices), dtype=bool)
            member[region] = True
            own = member[faces].all(axis=1)
            inside |= own
            edges = igl.boundary_facets(faces[own])[0]
            if not len(edges):
                continue
            rim = np.unique(edges)
            free = np.setdiff1d(np.unique(faces[own]), rim)
            near = member & False
            near[rim] = True
            for _ in range(RIM_RINGS):
                near[faces[own][near[faces[own]].any(axis=1)]] = True
            laplacian = -igl.cotmatrix(vertices, faces[own])[free][:, free]
            self.pockets.append(_Pocket(edges, free, free[~near[free]], laplacian))
        # Eyes and teeth lie in the pockets as they should.
        labels = component_labels(faces, len(vertices))
        own = np.isin(labels[faces[:, 0]], labels[faces[inside, 0]])
        self.skin = faces[own & ~inside]

    def tuck(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with all pockets inside."""
        vertices = np.array(vertices)
        touching = self._moves(vertices, self.pockets, self.touch)
        pockets = [pocket for pocket in self.pockets if touching[pocket.deep].any()]
        for _ in range(ROUNDS):
            if not pockets:
                break
            moves = self._moves(vertices, pockets, self.margin)
            for pocket in pockets:
                move = moves[pocket.free]
                hold = sp.diags(_PULL * pocket.laplacian.diagonal().mean() * move.any(axis=1))
                vertices[pocket.free] += Cholesky(pocket.laplacian + hold).solve(hold @ move)
            pockets = [pocket for pocket in pockets if moves[pocket.deep].any()]
        return vertices

    def _moves(self, vertices: np.ndarray, pockets: Sequence[_Pocket], required: float) -> np.ndarray:
        """(V, 3) how far the vertices of pockets must go to be inside the skin by a required distance."""
        moves = np.zeros_like(vertices)
        ids = np.concatenate([np.zeros(0, int), *(pocket.deep for pocket in pockets)])
        if not len(ids):
            return moves
        closed, surface = self._closed(vertices)
        points = vertices[ids]
        squared, face, nearest = igl.point_mesh_squared_distance(points, closed, self.skin)
        distance = np.sqrt(squared)
        away = points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, the winding number decides.
        outside = (triangle_normals(closed, self.skin)[face] * away).sum(1) > 0
        if outside.any():
            outside[outside] = igl.fast_winding_number(closed, surface, points[outside]) < 0.5
        missing = np.where(outside, distance + required, np.maximum(required - distance, 0))
        moves[ids] = (np.where(outside, -1.0, 1.0) * missing / np.maximum(distance, 1e-9))[:, None] * away
        return moves

    def _closed(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vertices with the middles of the openings appended, and the skin's faces with the fans."""
        closed = [vertices]
        fans = []
        for number, pocket in enumerate(self.pockets):
            edges = pocket.edges
            closed.append(vertices[np.unique(edges)].mean(0, keepdims=True))
            # The pocket's boundary runs as the pocket sees it, which is the direction that the cap needs.
            fans.append(np.column_stack([edges, np.full(len(edges), len(vertices) + number)]))
        return np.concatenate(closed), np.concatenate([self.skin, *fans])
