"""A picture that follows a mesh from one shape into another."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.deformation.smooth_displacement import Borders, Samples, smooth_displacement
from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.stylise.picture_warp import PictureWarp
from caricli.methods.stylise.settings import WarpSettings
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Face
from caricli.template.template import Template

_FINER = 2
"""Places in a cell, in each direction, where the mesh is asked."""

_FEWEST = 6
"""Nodes of a grid in each direction."""

_SMALLEST = 8
"""Pixels of a picture each way that can give way."""

_POCKETS = ("inner_mouth", "eye_socket_left", "eye_socket_right")
"""What lies behind the skin: teeth and eyes are not it, and go with the lips and lids around them."""


def mesh_warp(
    face: Face, vertices: np.ndarray, template: Template, size: tuple[int, int], settings: WarpSettings
) -> PictureWarp:
    """Find how a picture follows its face into another shape.

    Wherever the camera sees the surface in both shapes it says where its pixels come from, the more it faces the camera
    the more strongly. Between and around, over hair, background and the inside of an open mouth, the displacement is a
    thin plate, which ends without a seam in the picture around, and folds nowhere (``smooth_displacement``).
    face: Face with the camera of the picture. vertices: (V, 3) metres, the shape that it is to have. template: Template
    of its topology. size: (width, height) pixels. settings: WarpSettings.
    Returns PictureWarp. Raises InputError for a picture of few pixels, and NumericsError.
    """
    if min(size) < _SMALLEST:
        raise InputError(f"expected a picture of at least {_SMALLEST} pixels each way, found {size[0]} x {size[1]}")
    camera = face.require_camera()
    before, after = (camera.place(shape) for shape in (face.vertices, vertices))
    diagonal = float(np.linalg.norm(np.ptp(face.require_landmarks(), axis=0)))
    window = _Window.around(np.concatenate([before, after])[:, :2], size, diagonal, settings)
    skin = ~template.mask(*_POCKETS)[template.faces].all(axis=1)
    samples = _samples(window.cells(before), window.cells(after), template.faces[skin], window, settings)
    moves = smooth_displacement(samples, window.nodes, window.borders, settings.smoothness)
    return PictureWarp.of_grid(window.corner, moves * window.cell, window.size)


@dataclass(frozen=True, eq=False)
class _Window:
    """The part of a picture that gives way, and the grid on it.

    corner: (2,) int, x and y of its first pixel. size: (w, h) pixels. nodes: (R, C). borders: Borders.
    """

    corner: np.ndarray
    size: tuple[int, int]
    nodes: tuple[int, int]
    borders: Borders

    @classmethod
    def around(cls, pixels: np.ndarray, size: tuple[int, int], diagonal: float, settings: WarpSettings) -> "_Window":
        """Around pixels (N, 2). size: of the picture. diagonal: of the landmarks, pixels."""
        margin = settings.margin * diagonal
        last = np.array(size) - 1
        first = np.clip(np.floor(pixels.min(0) - margin), 0, last - 1).astype(int)
        end = np.clip(np.ceil(pixels.max(0) + margin), first + 1, last).astype(int)
        count = np.ceil((end - first) / max(1.0, settings.cell * diagonal)).astype(int) + 1
        columns, rows = (int(number) for number in np.maximum(count, _FEWEST))
        width, height = (int(number) for number in end - first + 1)
        open_ends = Borders(*(bool(inside) for inside in (*(first > 0), *(end < last))))
        return cls(first, (width, height), (rows, columns), open_ends)

    @property
    def cell(self) -> np.ndarray:
        """(2,) pixels, width and height of a cell."""
        return (np.array(self.size) - 1) / (np.array(self.nodes[::-1]) - 1)

    def cells(self, placed: np.ndarray) -> np.ndarray:
        """Pixels and depth (V, 3) in cells from the corner."""
        moved = placed - [*self.corner, 0]
        return moved / [*self.cell, self.cell.mean()]


def _samples(
    before: np.ndarray, after: np.ndarray, faces: np.ndarray, window: _Window, settings: WarpSettings
) -> Samples:
    """Where the mesh says from where the new picture's pixels come. before, after: (V, 3) cells."""
    height, width = (_FINER * count for count in window.nodes)
    seen, shown = (rasterise(_FINER * shape, faces, width, height) for shape in (before, after))
    rows, columns = np.nonzero(shown.face >= 0)
    triangle = shown.face[rows, columns]
    weights = shown.barycentric[rows, columns]
    sources = np.einsum("nk,nkc->nc", weights, before[faces[triangle]])
    places = np.stack([columns, rows], 1) / _FINER
    nearest = np.rint(_FINER * sources[:, :2]).astype(int)
    inside = ((nearest >= 0) & (nearest < [width, height])).all(axis=1)
    x, y = np.clip(nearest, 0, [width - 1, height - 1]).T
    open_to_sight = inside & (_FINER * sources[:, 2] < seen.depth[y, x] + _FINER * settings.depth / settings.cell)
    facing = np.minimum(_facing(before, faces), _facing(after, faces))[triangle]
    kept = open_to_sight & (facing > settings.facing)
    return Samples(places[kept], (sources[:, :2] - places)[kept], facing[kept] ** 2 / _FINER**2)


def _facing(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) cosines between the triangles' normals and the line of sight."""
    normals = triangle_normals(vertices, faces)
    return np.abs(normals[:, 2]) / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
