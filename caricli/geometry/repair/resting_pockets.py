"""Pockets of a face that moves: what cannot have come out is not looked at."""

import igl
import numpy as np
from scipy.spatial import KDTree

from caricli.geometry.repair.tuck_cavities import Cavities

_OUT = -1.0  # as far inside as what is outside at rest: looked at whatever moves


class RestingPockets:
    """How far the pockets of a face are behind its skin before it moves.

    Pockets and skin that move towards each other by less than that do not meet.
    """

    def __init__(self, cavities: Cavities, vertices: np.ndarray) -> None:
        """cavities: of the face's topology. vertices: (V, 3), the face at rest, as large as their template."""
        self.cavities = cavities
        self.vertices = np.asarray(vertices, float)
        self.closed, self.surface = cavities.closed(self.vertices)
        spots = [pocket.spots @ self.vertices for pocket in cavities.pockets]
        self.depths = [self._depths(points) for points in spots]
        self.gaps = [self._gaps(points) for points in spots]

    def withdraw(self, vertices: np.ndarray) -> np.ndarray:
        """``Cavities.withdraw`` of the face (V, 3) that has moved."""
        moved = vertices - self.vertices
        solid = self.cavities.closed(vertices)
        reach = np.linalg.norm(solid[0] - self.closed, axis=1)[self.surface].max(axis=1)
        asked = []
        for pocket, depths, gaps in zip(self.cavities.pockets, self.depths, self.gaps, strict=True):
            own = np.linalg.norm(pocket.spots @ moved, axis=1)
            towards = reach[reach + own.max(initial=0.0) > gaps].max(initial=0.0)
            asked.append(depths < own + towards)
        return self.cavities.withdraw(vertices, np.concatenate([np.zeros(0, bool), *asked]), solid)

    def _depths(self, points: np.ndarray) -> np.ndarray:
        """(P,) how far points (P, 3) are from the closed skin, negative outside."""
        depths = np.sqrt(igl.point_mesh_squared_distance(points, self.closed, self.surface)[0])
        depths[igl.fast_winding_number(self.closed, self.surface, points) < 0.5] = _OUT
        return depths

    def _gaps(self, points: np.ndarray) -> np.ndarray:
        """(F,) what triangles of the closed skin are from the nearest of points (P, 3) at least."""
        corners = KDTree(points).query(self.closed)[0][self.surface]
        longest = np.sqrt(igl.squared_edge_lengths(self.closed, self.surface).max(axis=1))
        return corners.min(axis=1) - longest
