"""Which points before or on a mesh a picture shows."""

from typing import Any

import numpy as np

from caricli.io.start_warp import start_warp
from caricli.render.visibility.rasterise import depth_range, mesh_arrays, wp_mesh


def seen_points(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """Which points nothing hides, by a ray into the picture for each.

    points: (N, 3), vertices: (V, 3), pixels and depth, as `rasterise` takes them. faces: (F, 3). tolerance: pixels that
    the mesh may lie before a point that is seen.
    Returns (N,) bool.
    """
    if not len(points) or not len(faces):
        return np.ones(len(points), bool)
    start_warp()
    import warp as wp

    from caricli.render.visibility import point_kernels

    corners, triangles = mesh_arrays(vertices, faces)
    mesh = wp_mesh(corners, triangles)
    start = min(depth_range(corners)[0], float(points[:, 2].min()) - 1)
    before = np.zeros(len(points), np.float32)
    places: Any = wp.array(np.ascontiguousarray(points, np.float32), dtype=wp.vec3, device="cpu")
    into: Any = wp.array(before, dtype=wp.float32, device="cpu", copy=False)
    wp.launch(point_kernels.depth_before, len(points), [mesh.id, start, places], [into], device="cpu")
    return before <= tolerance
