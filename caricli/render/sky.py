"""How much of the sky each vertex sees: the source of soft shadows."""

import numpy as np

from caricli.render.rasterise import mesh_arrays, wp_mesh
from caricli.render.warp_start import warp_start


def _sphere(count):
    """Directions spread evenly over the sphere on a Fibonacci spiral, (count, 3)."""
    k = np.arange(count) + 0.5
    y, turn = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.cos(turn), y, r * np.sin(turn)], 1)


DIRECTIONS = _sphere(64)


def sky_visibility(vertices, faces, normals):
    """See from every vertex which of DIRECTIONS end in the sky and which in the mesh itself.

    vertices: (V, 3), any unit. faces: (F, 3), counter-clockwise from outside. normals: (V, 3), unit length.
    Returns (V, len(DIRECTIONS)) float32: one for sky; zero for mesh and for directions behind the surface.
    """
    kernels = warp_start()
    import warp as wp

    points, triangles = mesh_arrays(vertices, faces)
    seen = np.zeros((len(points), len(DIRECTIONS)), np.float32)
    if len(triangles):
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        points = (points - points.mean(0)) / np.float32(size or 1)
        mesh = wp_mesh(points, triangles)
        wp.launch(
            kernels.sky_seen,
            seen.shape,
            [mesh.id]
            + [wp.array(a, dtype=wp.vec3, device="cpu") for a in (points, normals.astype(np.float32), DIRECTIONS)]
            + [1e-3, 2.0],
            [wp.array(seen, device="cpu", copy=False)],
            device="cpu",
        )
    return seen


def light_received(visibility, normals, light=None, sharpness=12.0):
    """Share of a light's rays that reach each vertex, of all that could without the mesh in the way.

    visibility: of `sky_visibility`. normals: (V, 3), in the same frame. light: (3,) the way to a wide light in that
    frame, or None for the whole sky. sharpness: exponent of the light's cosine lobe; higher is smaller.
    Returns (V,) in [0, 1]; one where the light is behind the surface.
    """
    could = np.maximum(normals @ DIRECTIONS.T, 0)
    if light is not None:
        could *= np.maximum(DIRECTIONS @ light, 0) ** sharpness
    total = could.sum(1)
    return np.where(total > 1e-6, (could * visibility).sum(1) / np.maximum(total, 1e-6), 1)
