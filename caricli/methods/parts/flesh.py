"""What the skin of a face encloses."""

from functools import cached_property

import igl
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals

_ON_EDGE = 1e-7
"""Barycentric coordinate below which a point of a triangle is on its edge."""

ASKED_FIRST = 4
"""Of so many points in doubt one is asked first: a fold that covers some covers many."""


class Hide:
    """A piece of skin, or all of it, closed over its rim towards one point."""

    def __init__(self, faces: np.ndarray, inwards: bool = False) -> None:
        """faces: (F, 3) of the piece, vertex ids of the whole skin. inwards: whether it faces what it encloses."""
        self.ids, local = np.unique(faces, return_inverse=True)
        self.faces = local.reshape(-1, 3).astype(np.int64)
        edges = igl.boundary_facets(self.faces)[0]
        self.rim = np.unique(edges)
        fan = np.column_stack([edges[:, ::-1], np.full(len(edges), len(self.ids))])
        closed = np.concatenate([self.faces, fan])
        beyond = np.roll(igl.triangle_triangle_adjacency(self.faces)[0], -1, axis=1)
        self.across = np.where(beyond < 0, np.arange(len(self.faces))[:, None], beyond)
        # What faces inwards is turned over, so that the winding number is one inside.
        self.closed = closed[:, ::-1].copy() if inwards else closed

    def behind(self, skin: np.ndarray, far: float) -> np.ndarray:
        """(3,) metres, a point so far behind the middle of its rim, on the side that its skin (S, 3) turns away from.

        Closed to a point in the head, a piece may be closed before what lies deep in it.
        """
        ahead = triangle_normals(skin, self.faces).sum(0)
        return skin[self.rim].mean(0) - far * ahead / np.linalg.norm(ahead)


class Flesh:
    """What a Hide encloses in the shape of one face."""

    def __init__(
        self,
        hide: Hide,
        skin: np.ndarray,
        towards: np.ndarray | None = None,
        doubt: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """skin: (S, 3) metres, of the vertices of the hide. towards: (3,) metres, the point that it is closed to, the
        middle of its rim where none is given. doubt: metres; so far from it, at least and at most, another fold of it
        may cover a point than what is nearest to that."""
        self.skin = np.ascontiguousarray(skin, float)
        self.hide = hide
        self.doubt = doubt
        self.last = self.skin[hide.rim].mean(0) if towards is None else towards

    @cached_property
    def _tree(self) -> igl.AABB:
        tree = igl.AABB()
        tree.init(self.skin, self.hide.faces)
        return tree

    @cached_property
    def _enclosed(self) -> igl.FastWindingNumberBVH:
        enclosed = igl.FastWindingNumberBVH()
        enclosed.init(np.concatenate([self.skin, self.last[None]]), self.hide.closed)
        return enclosed

    @cached_property
    def _normals(self) -> np.ndarray:
        return igl.per_vertex_normals(self.skin, self.hide.faces)

    @cached_property
    def face_normals(self) -> np.ndarray:
        """(F, 3) of unit length."""
        normals = triangle_normals(self.skin, self.hide.faces)
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)

    @cached_property
    def _corner_normals(self) -> np.ndarray:
        return igl.per_vertex_normals(self.skin, self.hide.faces, weighting=igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Squared distances (N,) of points (N, 3) from the skin, the nearest faces (N,) and what is nearest (N, 3)."""
        return self._tree.squared_distance(self.skin, self.hide.faces, np.ascontiguousarray(points))

    def ahead(self, points: np.ndarray, face: np.ndarray, nearest: np.ndarray) -> np.ndarray:
        """(N,) how far points (N, 3) are on the side that the skin faces, negative behind it, in no unit.

        What is nearest to a point may be an edge or a corner, of which any of its faces is told: their normals count
        together. face, nearest: (N,) and (N, 3), of ``nearest``.
        """
        corners = self.hide.faces[face]
        shares = igl.barycentric_coordinates(nearest, *(self.skin[corners[:, k]] for k in range(3)))
        beside = shares < _ON_EDGE
        normals = self.face_normals[face]
        edges = np.flatnonzero(beside.sum(1) == 1)
        other = self.hide.across[face[edges], beside[edges].argmax(1)]
        normals[edges] += self.face_normals[other]
        at_corner = np.flatnonzero(beside.sum(1) > 1)
        if len(at_corner):
            normals[at_corner] = self._corner_normals[corners[at_corner, shares[at_corner].argmax(1)]]
        sides: np.ndarray = (normals * (points - nearest)).sum(1)
        return sides

    def holds(self, points: np.ndarray) -> np.ndarray:
        """(N,) whether points (N, 3) are in it."""
        if not len(points):
            return np.zeros(0, bool)
        return self._enclosed.winding_number(np.ascontiguousarray(points)) > 0.5

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from the skin, negative in the flesh, and unit ways (N, 3) out of it."""
        squared, _, nearest = self.nearest(points)
        distance = np.sqrt(squared)
        sign = np.where(self.holds(points), -1.0, 1.0)
        return sign * distance, sign[:, None] * (points - nearest) / np.maximum(distance, 1e-9)[:, None]

    def ways_out(self, points: np.ndarray, deeper: np.ndarray) -> np.ndarray:
        """(N, 3) from points (N, 3) in the flesh deeper than so many metres (N,) to the nearest of the skin, else zero.

        Quicker than ``room`` where few points are.
        """
        squared, face, nearest = self.nearest(points)
        corners = self.hide.faces[face]
        shares = igl.barycentric_coordinates(nearest, *(self.skin[corners[:, k]] for k in range(3)))
        normals = np.einsum("nk,nkc->nc", shares, self._normals[corners])
        deep = squared > deeper**2
        # The side of what is nearest is mostly right; where it says inside, and in doubt, the winding number decides.
        inside = deep & ((normals * (points - nearest)).sum(1) < 0)
        least, most = self.doubt
        doubtful = np.flatnonzero(deep & ~inside & (squared > least**2) & (squared < most**2))
        if self.holds(points[doubtful[::ASKED_FIRST]]).any():
            inside[doubtful] = True
        if inside.any():
            inside[inside] = self.holds(points[inside])
        return np.where(inside[:, None], nearest - points, 0.0)
