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


DIRECTIONS = _sphere(48)


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


def light_received(visibility, normals, lights, sharpness=8.0):
    """Share of each light's rays that reach each vertex, of all that could without the mesh in the way.

    visibility: of `sky_visibility`. normals: (V, 3), in the same frame. lights: L times the way (3,) to a wide light in
    that frame, unit length, or None for the whole sky. sharpness: exponent of a light's cosine lobe; higher is smaller.
    Returns (V, L) float32 in [0, 1]; one where the light is behind the surface.
    """
    kernels = warp_start()
    import warp as wp

    way = [np.zeros(3) if light is None else np.asarray(light) for light in lights]
    lobes = np.maximum((DIRECTIONS[None] * np.array(way)[:, None]).sum(-1), 0) ** sharpness
    lobes[[light is None for light in lights]] = 1
    share = np.ones((len(normals), len(lights)), np.float32)
    if share.size:
        vectors = [wp.array(a.astype(np.float32), dtype=wp.vec3, device="cpu") for a in (normals, DIRECTIONS)]
        seen, strengths, out = (
            wp.array(a, device="cpu", copy=False) for a in (visibility, lobes.astype(np.float32), share)
        )
        wp.launch(kernels.light_share, share.shape, [seen, *vectors, strengths], [out], device="cpu")
    return share
