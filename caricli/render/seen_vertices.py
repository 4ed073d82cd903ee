"""Which vertices a picture shows."""

from typing import Any

import numpy as np

from caricli.render.rasterise import depth_range, mesh_arrays, wp_mesh
from caricli.render.warp_start import warp_start

_RAYS = 2  # for every triangle, over the whole picture; all neighbours of what they meet count as seen
_STEP = 2  # pixels between rays, at most: teeth are small


def seen_vertices(vertices: np.ndarray, faces: np.ndarray, width: int, height: int) -> np.ndarray:
    """Find the corners of the triangles that are seen from outside, and their neighbours'.

    vertices: (V, 3), pixels and depth, as `rasterise` takes them. faces: (F, 3). width, height: pixels.
    Returns (V,) bool.
    """
    kernels = warp_start()
    import warp as wp

    points, triangles = mesh_arrays(vertices, faces)
    step = float(np.clip(np.sqrt(width * height / max(_RAYS * len(triangles), 1)), 1, _STEP))
    columns = max(round(width / step), 1)
    rows = max(round(height / step), 1)
    hit = np.full(rows * columns, -1, np.int32)
    seen = np.zeros(len(points), bool)
    if len(triangles):
        mesh = wp_mesh(points, triangles)
        rays = kernels.Rays()
        rays.mesh = mesh.id
        rays.start, rays.reach = depth_range(points)
        met: Any = wp.array(hit, device="cpu", copy=False)
        wp.launch(
            kernels.outside_face,
            len(hit),
            [rays, columns, wp.vec2(width / columns, height / rows)],
            [met],
            device="cpu",
        )
        seen[triangles[hit[hit >= 0]]] = True
        seen[triangles[seen[triangles].any(1)]] = True
    return seen
