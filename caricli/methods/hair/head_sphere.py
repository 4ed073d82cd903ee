"""A head seen from its middle: directions on a sphere, and how far out the skin is in each."""

from copy import copy
from functools import cached_property
from typing import Self

import igl
import numpy as np
import scipy.sparse as sp
from scipy.ndimage import maximum_filter
from scipy.spatial import KDTree

from caricli.geometry.join_meshes import join_meshes
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.parts.close_neck import close_neck, neck_edge
from caricli.render.visibility.nearest_pixel import nearest_pixel
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Mesh
from caricli.template.annotation import EARS
from caricli.template.template import Template

_FINE = 512  # pixels, side of the map of directions
_NEAR = 5  # cells of a grid that are near each other: vertices of a skull are farther apart than one
_LOW, _LOWEST, _TURN = np.pi * np.array([0.5, 0.97, 0.25])  # angles from the whorl, and turns, of triangles on a map
_NEAR_EAR = 0.02  # of the head's height: points so far from an ear may be in it


class HeadSphere:
    """Directions from the middle of a head, around its whorl: the pole, at the top behind.

    A direction is (longitude, angle): radians around the whorl, 0 towards the face and growing to the subject's left,
    and radians from the whorl. Maps (R, C) hold a value for every direction of a grid: row r is at the angle
    ``angles[r]``, column c at the longitude ``longitudes[c]``.

    middle: (3,) metres, between the ears.
    """

    def __init__(self, head: Template, settings: ShellSettings, fine: bool = False) -> None:
        """head: Template in the shape of the face, whose annotation names the ears. fine: with the finer grid."""
        rows, columns = settings.fine if fine else settings.coarse
        self.ears = [head.vertices[head.annotation.regions[name]] for name in EARS]
        self.head = head
        self.middle = (self.ears[0].mean(0) + self.ears[1].mean(0)) / 2
        tilt = np.radians(settings.tilt)
        up = np.array([0, np.cos(tilt), -np.sin(tilt)])
        front = np.array([0, np.sin(tilt), np.cos(tilt)])
        self.axes = np.stack([np.array([1.0, 0, 0]), front, up])
        self.longitudes = 2 * np.pi * np.arange(columns) / columns
        self.angles = np.pi * (np.arange(rows) + 0.5) / rows

    def with_head(self, head: Template) -> Self:
        """The same directions around a head whose skull has moved along them: what is outermost there stays so."""
        moved = copy(self)
        moved._skin = self._skin
        moved._grid_rays = self._grid_rays
        moved.head = head
        for name in ("_grid_roots", "radii"):
            moved.__dict__.pop(name, None)
        return moved

    def points(self, longitudes: np.ndarray, angles: np.ndarray, radii: np.ndarray) -> np.ndarray:
        """(..., 3) metres, so far (...) from the middle in directions (...)."""
        return self.middle + radii[..., None] * self.directions(longitudes, angles)

    def directions(self, longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """(..., 3) unit vectors."""
        out = np.sin(angles)
        local = np.stack([out * np.sin(longitudes), out * np.cos(longitudes), np.cos(angles)], -1)
        return local @ self.axes

    def seen_from(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Longitudes, angles and radii of points (..., 3)."""
        local = (points - self.middle) @ self.axes.T
        radii = np.linalg.norm(local, axis=-1)
        angles = np.arccos(np.clip(local[..., 2] / np.maximum(radii, 1e-9), -1, 1))
        return np.arctan2(local[..., 0], local[..., 1]), angles, radii

    def sample(self, values: np.ndarray, longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Values (...) of a map (R, C) of any grid in directions (...), between its rows and columns."""
        rows, columns = values.shape
        column = np.mod(longitudes, 2 * np.pi) / (2 * np.pi) * columns
        row = np.clip(angles / np.pi * rows - 0.5, 0, rows - 1)
        left = np.floor(column).astype(int)
        top = np.minimum(np.floor(row).astype(int), rows - 2)
        x = column - left
        y = row - top
        left %= columns
        right = (left + 1) % columns
        upper = (1 - x) * values[top, left] + x * values[top, right]
        return (1 - y) * upper + y * ((1 - x) * values[top + 1, left] + x * values[top + 1, right])

    def ground(self, longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """(...) metres, how far out the skin is in directions (...), ears left out."""
        return self.sample(self.radii, longitudes, angles)

    def heights(self, points: np.ndarray) -> np.ndarray:
        """(...) metres, how far above the skin points (..., 3) are, below zero under it."""
        longitudes, angles, radii = self.seen_from(points)
        return radii - self.ground(longitudes, angles)

    def nearest(self, values: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Values (N,) of a map (R, C) of any grid in the direction that is nearest to that of points (N, 3)."""
        return values[self._cells(values.shape, points)]

    def farthest(self, points: np.ndarray) -> np.ndarray:
        """(R, C) how far out the farthest of points (N, 3) is near each direction, infinitely inwards without one."""
        farthest = np.full((len(self.angles), len(self.longitudes)), -np.inf)
        _, _, radii = self.seen_from(points)
        np.maximum.at(farthest, self._cells(farthest.shape, points), radii)
        return maximum_filter(farthest, _NEAR, mode=("nearest", "wrap"))

    def near_ears(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool: which of points (N, 3) are near an ear."""
        near: np.ndarray = KDTree(np.concatenate(self.ears)).query(points)[0] < _NEAR_EAR * self.head.height
        return near

    def encloses(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool: which of points (N, 3) are in the flesh of the head, ears included."""
        return _inside(self.head, points)

    def in_neck(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool: which of points (N, 3) are in the neck, also in what it stands on below the end of the skin."""
        inside = np.zeros(len(points), bool)
        foot = close_neck(self.head, self.head.vertices)
        if foot is None:
            return inside
        low = points[:, 1] < self.head.vertices[neck_edge(self.head), 1].max()
        inside[low] = _inside(join_meshes([self.head, foot.mesh]), points[low])
        return inside

    def _cells(self, shape: tuple[int, ...], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (N,) of the directions of points (N, 3) in maps of a shape."""
        longitudes, angles, _ = self.seen_from(points)
        rows, columns = shape
        row = np.clip(np.round(angles / np.pi * rows - 0.5).astype(int), 0, rows - 1)
        column = np.round(np.mod(longitudes, 2 * np.pi) / (2 * np.pi) * columns).astype(int) % columns
        return row, column

    @cached_property
    def _skin(self) -> tuple[np.ndarray, np.ndarray]:
        """Faces of the skin without ears and pockets, and (S, S) which is outermost in every direction of a disc."""
        head = self.head
        inner = head.mask(*EARS, "inner_mouth", "eye_socket_left", "eye_socket_right", "nostril_left", "nostril_right")
        faces = head.faces[~inner[head.faces].any(1)]
        longitudes, angles, radii = self.seen_from(head.vertices)
        places = _disc(longitudes, angles)
        faces = faces[_flat(faces, longitudes, angles)]
        raster = rasterise(np.column_stack([*places, -radii * _FINE / head.height]), faces, _FINE, _FINE)
        return faces, raster.face[nearest_pixel(raster.face >= 0)]

    def roots(self, longitudes: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the skin is in directions (N,): vertices (N, 3) int32 and their weights (N, 3).

        Over ears and beyond the neck's end it is the nearest place of the skin elsewhere.
        """
        return self._met(*self._rays(longitudes, angles))

    def _rays(self, longitudes: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Corners (N, 3) of the triangles that directions (N,) meet, and the directions (N, 3)."""
        faces, owner = self._skin
        x, y = _disc(longitudes, angles)
        column, row = (np.clip(np.round(a).astype(int), 0, _FINE - 1) for a in (x, y))
        return faces[owner[row, column]], self.directions(longitudes, angles)

    def _met(self, corners: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Those corners (N, 3) int32 and their weights (N, 3) where rays (N, 3) from the middle meet the triangles."""
        a, b, c = np.swapaxes(self.head.vertices[corners] - self.middle, 0, 1)
        weights = np.stack([np.einsum("nc,nc->n", rays, np.cross(*edge)) for edge in ((b, c), (c, a), (a, b))], 1)
        total = weights.sum(1, keepdims=True)
        weights = np.clip(np.divide(weights, total, out=np.ones_like(weights), where=total != 0), 0, 1)
        return corners.astype(np.int32), weights / weights.sum(1, keepdims=True)

    @cached_property
    def _grid_roots(self) -> tuple[np.ndarray, np.ndarray]:
        """`roots` of all directions of the grid, row by row."""
        return self._met(*self._grid_rays)

    @cached_property
    def _grid_rays(self) -> tuple[np.ndarray, np.ndarray]:
        """`_rays` of all directions of the grid, row by row."""
        longitudes, angles = np.meshgrid(self.longitudes, self.angles)
        return self._rays(longitudes.ravel(), angles.ravel())

    def cover(self, vertices: np.ndarray, faces: np.ndarray, longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """How far out triangles (F, 3) of vertices (V, 3) are in directions (N,), infinite where there are none."""
        around, down, radii = self.seen_from(vertices)
        faces = faces[_flat(faces, around, down)]
        raster = rasterise(np.column_stack([*_disc(around, down), -radii]), faces, _FINE, _FINE)
        x, y = (np.clip(np.round(each).astype(int), 0, _FINE - 1) for each in _disc(longitudes, angles))
        return np.where(raster.face >= 0, -raster.depth, np.inf)[y, x]

    @cached_property
    def radii(self) -> np.ndarray:
        """(R, C) map of how far out the skin is, ears left out."""
        corners, weights = self._grid_roots
        points = np.einsum("nk,nkc->nc", weights, self.head.vertices[corners])
        return np.linalg.norm(points - self.middle, axis=1).reshape(len(self.angles), len(self.longitudes))

    def region(self, *names: str) -> np.ndarray:
        """(R, C) map, from 0 to 1: how far the skin there is of regions."""
        corners, weights = self._grid_roots
        return (weights * self.head.mask(*names)[corners]).sum(1).reshape(len(self.angles), len(self.longitudes))

    @cached_property
    def bending(self) -> tuple[np.ndarray, np.ndarray]:
        """Bending of maps, and the areas (n,) of their cells on the unit sphere.

        The first is a symmetric matrix (n, n), by the diagonals (2 C + 1, n) of its upper half, the main one last, as
        LAPACK takes them.
        """
        rows = len(self.angles)
        columns = len(self.longitudes)
        sine = np.sin(self.angles)
        step = np.pi / rows
        turn = 2 * np.pi / columns
        ids = np.arange(rows * columns).reshape(rows, columns)
        around = np.repeat((step / (turn * sine))[:, None], columns, 1)
        along = np.repeat((np.sin((self.angles[1:] + self.angles[:-1]) / 2) * turn / step)[:, None], columns, 1)
        first = np.concatenate([ids.ravel(), ids[:-1].ravel()])
        second = np.concatenate([np.roll(ids, -1, 1).ravel(), ids[1:].ravel()])
        weights = np.concatenate([around.ravel(), along.ravel()])
        adjacency = sp.csr_matrix((weights, (first, second)), (ids.size, ids.size))
        adjacency = adjacency + adjacency.T
        laplacian = sp.diags(np.asarray(adjacency.sum(1)).ravel()) - adjacency
        areas = np.repeat(sine * step * turn, columns)
        entries = sp.triu(laplacian @ sp.diags(1 / areas) @ laplacian).tocoo()
        diagonals = np.zeros((2 * columns + 1, ids.size))
        diagonals[2 * columns - (entries.col - entries.row), entries.col] = entries.data
        return diagonals, areas


def _disc(longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(2, ...) pixels of directions (...) on the map of directions, the whorl in the middle."""
    return _FINE / 2 * (1 + angles / np.pi * np.stack([np.sin(longitudes), np.cos(longitudes)])) - 0.5


def _flat(faces: np.ndarray, longitudes: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(F,) bool: which triangles (F, 3) of vertices in directions (V,) the map of directions shows where they are.

    What goes around the lower pole would cover the whole disc, and what goes around a part of it would cut a slice off.
    """
    turns = longitudes[faces] - longitudes[np.roll(faces, 1, axis=1)]
    turns = np.abs(np.mod(turns + np.pi, 2 * np.pi) - np.pi).max(1)
    lowest = angles[faces].max(1)
    flat: np.ndarray = (lowest < _LOW) | ((turns < _TURN) & (lowest < _LOWEST))
    return flat


def _inside(body: Mesh, points: np.ndarray) -> np.ndarray:
    """(N,) bool: which of points (N, 3) are in a body."""
    inside: np.ndarray = igl.winding_number(body.vertices.astype(float), np.asarray(body.faces, np.int64), points) > 0.5
    return inside
