"""Which vertices a picture shows."""

import cv2
import numpy as np

from caricli.geometry.places_of import places_of
from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.visibility.rasterise import mesh_arrays, rasterise

_CELLS = 2  # for every triangle, over the whole picture; all neighbours of what is seen there count as seen
_LARGEST = 2  # pixels, side of a cell: teeth are small
_AROUND = np.ones((3, 3), np.uint8)  # cells, of which the deepest says how deep the surface may be there


def seen_vertices(vertices: np.ndarray, faces: np.ndarray, width: int, height: int) -> np.ndarray:
    """Find the corners of the triangles that are seen from outside, and their neighbours'.

    Triangles smaller than pixels are seen where no other is before one of their corners.

    vertices: (V, 3), pixels and depth, as `rasterise` takes them. faces: (F, 3). width, height: pixels.
    Returns (V,) bool.
    """
    points, triangles = mesh_arrays(vertices, faces)
    side = float(np.clip(np.sqrt(width * height / max(_CELLS * len(triangles), 1)), 1, _LARGEST))
    columns = max(round(width / side), 1)
    rows = max(round(height / side), 1)
    half = np.array([0.5, 0.5, 0.0])
    placed = (points + half) * [columns / width, rows / height, 1.0] - half
    outer = triangles[triangle_normals(placed, triangles)[:, 2] < 0]
    raster = rasterise(placed, outer, columns, rows)
    seen = np.zeros(len(points), bool)
    seen[outer] = True
    seen &= _uncovered(placed, raster.depth)
    seen[outer[raster.face[raster.face >= 0]]] = True
    # Neighbours are told by place: every triangle of a split mesh has corners of its own.
    corners = places_of(points)[triangles]
    seen_places = np.zeros(len(points), bool)
    seen_places[corners[seen[triangles]]] = True
    seen[triangles[seen_places[corners].any(1)]] = True
    return seen


def _uncovered(placed: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """(V,) bool: points (V, 3) in the picture that are no deeper than what its cells around them show, depth (H, W)."""
    column, row = np.rint(placed[:, :2]).astype(int).T
    inside = (column >= 0) & (column < depth.shape[1]) & (row >= 0) & (row < depth.shape[0])
    deepest = cv2.dilate(depth, _AROUND)
    inside[inside] = placed[inside, 2] <= deepest[row[inside], column[inside]]
    return inside
