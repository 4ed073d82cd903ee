"""Mouth cavity and eye sockets kept behind the skin."""

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from caricli.geometry.triangle_normals import triangle_normals

MARGIN = 0.006
ROUNDS = 5


class Cavities:
    """The pockets of a head, which no landmark holds and which a flattened face would push through the skin.

    The skin is everything but the pockets, each opening closed by a fan. A pocket vertex outside the skin (generalised
    winding number below one half) or nearer to it than ``MARGIN`` of the head's height is moved inwards from its
    nearest point on the skin; the rest of the pocket follows as a membrane whose rim stays.
    """

    def __init__(self, vertices, faces, regions):
        """vertices: (V, 3) template. faces: (F, 3). regions: lists of vertex ids, one for each pocket."""
        self.faces, self.margin, self.pockets = faces, MARGIN * np.ptp(vertices[:, 1]), []
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
            # Near the rim the pocket touches the skin by its nature.
            depth = _rings(faces[own], rim, len(vertices))
            laplacian = -igl.cotmatrix(vertices, faces[own])[free][:, free]
            self.pockets.append((edges, free, depth[free] > 2, laplacian))
        self.skin = faces[~inside]

    def tuck(self, vertices, rounds=ROUNDS):
        """Vertices (V, 3) with all pockets inside."""
        if not self.pockets:
            return vertices
        vertices = np.array(vertices)
        deep = np.concatenate([free[below] for _, free, below, _ in self.pockets])
        for _ in range(rounds):
            steps = self._steps(vertices, deep)
            if not steps.any():
                break
            for _, free, _, laplacian in self.pockets:
                held = steps[free].any(axis=1)
                if held.any():
                    hold = sp.diags(1e3 * laplacian.diagonal().mean() * held)
                    vertices[free] += splu((laplacian + hold).tocsc()).solve(hold @ steps[free])
        return vertices

    def _steps(self, vertices, ids):
        """(V, 3) how far the vertices ``ids`` must go to be inside by the margin; zero for all others."""
        closed, surface = self._closed(vertices)
        points = vertices[ids]
        squared, face, nearest = igl.point_mesh_squared_distance(points, closed, self.skin)
        distance, away = np.sqrt(squared), points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, the winding number decides.
        outside = (triangle_normals(closed, self.skin)[face] * away).sum(1) > 0
        if outside.any():
            outside[outside] = igl.winding_number(closed, surface, points[outside]) < 0.5
        wrong = outside | (distance < self.margin)
        inwards = np.where(outside, -1.0, 1.0)[:, None] * away / np.maximum(distance, 1e-9)[:, None]
        steps = np.zeros_like(vertices)
        steps[ids] = (wrong * np.where(outside, distance + self.margin, self.margin - distance))[:, None] * inwards
        return steps

    def _closed(self, vertices):
        """Vertices with the middles of the openings appended, and the skin's faces with the fans."""
        closed, fans = [vertices], []
        for number, (edges, *_) in enumerate(self.pockets):
            closed.append(vertices[np.unique(edges)].mean(0, keepdims=True))
            # The pocket's boundary runs as the pocket sees it, which is the direction that the cap needs.
            fans.append(np.column_stack([edges, np.full(len(edges), len(vertices) + number)]))
        return np.concatenate(closed), np.concatenate([self.skin, *fans])


def _rings(faces, rim, count):
    """(V,) number of edges between a vertex and the rim, within these faces; large where they do not reach."""
    depth = np.full(count, 99)
    depth[rim] = 0
    for ring in range(1, 4):
        near = (depth[faces] < ring).any(axis=1)
        reached = np.unique(faces[near])
        depth[reached] = np.minimum(depth[reached], ring)
    return depth
