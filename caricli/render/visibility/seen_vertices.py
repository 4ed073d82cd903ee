"""Which vertices a picture shows."""

import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.visibility.rasterise import mesh_arrays, rasterise

_CELLS = 2  # for every triangle, over the whole picture; all neighbours of what is seen there count as seen
_LARGEST = 2  # pixels, side of a cell: teeth are small


def seen_vertices(vertices: np.ndarray, faces: np.ndarray, width: int, height: int) -> np.ndarray:
    """Find the corners of the triangles that are seen from outside, and their neighbours'.

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
    face = rasterise(placed, outer, columns, rows).face
    seen = np.zeros(len(points), bool)
    seen[outer[face[face >= 0]]] = True
    seen[triangles[seen[triangles].any(1)]] = True
    return seen
