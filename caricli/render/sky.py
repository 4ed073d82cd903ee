"""How much of the sky and of a wide light each vertex sees: the source of soft shadows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from caricli.geometry.used_points import used_points
from caricli.render.in_parallel import in_parallel
from caricli.render.load_kernels import load_kernels
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import mesh_arrays, wp_mesh

_LIFT = 1e-3  # of the mesh's size: rays start so far above the surface, which they would hit else
_REACH = 2.0  # of the mesh's size: no ray through it is longer
_BLOCK = 2048  # vertices that look around at a time
_SHARPNESS = 8.0  # exponent of the cosine lobe of a wide light: the higher the smaller
_KEY_RAYS = 16
_KEY_REACH = np.radians(16)  # half the angle that the key light fills: the wider the softer its shadows


def sphere_directions(count: int) -> np.ndarray:
    """Directions spread evenly over the sphere on a Fibonacci spiral, (count, 3)."""
    k = np.arange(count) + 0.5
    y = 1 - 2 * k / count
    turn = np.pi * (1 + np.sqrt(5)) * k
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.cos(turn), y, r * np.sin(turn)], 1)


DIRECTIONS = sphere_directions(48)
"""Ways to the sky, (D, 3)."""


def key_directions(way: np.ndarray) -> np.ndarray:
    """Ways (16, 3) to a disc of light on a Fibonacci spiral around the way (3,) to its middle, unit length."""
    k = np.arange(_KEY_RAYS) + 0.5
    r = np.tan(_KEY_REACH) * np.sqrt(k / _KEY_RAYS)
    turn = np.pi * (1 + np.sqrt(5)) * k
    aside = np.cross(way, [0.0, 1.0, 0.0])
    aside /= np.linalg.norm(aside)
    upward = np.cross(aside, way)
    ways = way + (r * np.cos(turn))[:, None] * aside + (r * np.sin(turn))[:, None] * upward
    return ways / np.linalg.norm(ways, axis=1, keepdims=True)


def sky_visibility(
    vertices: np.ndarray,
    faces: np.ndarray,
    normals: np.ndarray,
    ids: np.ndarray | None = None,
    directions: np.ndarray = DIRECTIONS,
) -> np.ndarray:
    """See from every vertex which directions end in the sky and which in the mesh itself.

    vertices: (V, 3), any unit. faces: (F, 3), counter-clockwise from outside. normals: (V, 3), unit length.
    ids: (N,) of the vertices that look around, or None for all. directions: (D, 3), unit length.
    Returns (V or N, D) float32: one for sky; zero for mesh and for directions behind the surface.
    """
    kernels = load_kernels()
    import warp as wp

    points, triangles = mesh_arrays(vertices, faces)
    around = slice(None) if ids is None else ids
    seen = np.zeros((len(points[around]), len(directions)), np.float32)
    if len(triangles) and len(seen):
        surface = used_points(points, triangles)
        size = float(np.linalg.norm(np.ptp(surface, axis=0)))
        points = (points - surface.mean(0)) / np.float32(size or 1)
        mesh = wp_mesh(points, triangles)
        rays = kernels.Rays()
        rays.mesh = mesh.id
        rays.start = _LIFT
        rays.reach = _REACH
        towards = _vectors(directions)
        origins = points[around]
        upwards = normals[around]

        def look(first: int) -> None:
            rows = slice(first, first + _BLOCK)
            given = [rays, _vectors(origins[rows]), _vectors(upwards[rows]), towards]
            wp.launch(kernels.sky_seen, seen[rows].shape, given, [_shared(seen[rows])], device="cpu")

        for _ in in_parallel(look, range(0, len(seen), _BLOCK)):
            pass
    return seen


def mesh_sky(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, D) float32: what every vertex of a mesh sees of the sky, see ``sky_visibility``; its pictures share it."""
    return sky_visibility(vertices, faces, smooth_normals(vertices, faces))


def light_received(
    visibility: np.ndarray,
    normals: np.ndarray,
    directions: np.ndarray,
    lights: Sequence[np.ndarray | None],
) -> np.ndarray:
    """Share of each light's rays that reach each vertex, of all that could without the mesh in the way.

    visibility: (V, D) of `sky_visibility` in directions (D, 3). normals: (V, 3), in the same frame. lights: L times the
    way (3,) to a wide light in that frame, unit length, or None for all directions alike.
    Returns (V, L) float32 in [0, 1]; one where the light is behind the surface.
    """
    kernels = load_kernels()
    import warp as wp

    ways = np.array([np.zeros(3) if light is None else np.asarray(light) for light in lights])
    lobes = np.maximum((directions[None] * ways[:, None]).sum(-1), 0) ** _SHARPNESS
    lobes[[light is None for light in lights]] = 1
    share = np.ones((len(normals), len(lights)), np.float32)
    if share.size:
        given = [_shared(visibility), _vectors(normals), _vectors(directions), _shared(lobes.astype(np.float32))]
        wp.launch(kernels.light_share, share.shape, given, [_shared(share)], device="cpu")
    return share


def _vectors(array: np.ndarray) -> Any:
    """A copy of (N, 3) as warp's vectors."""
    import warp as wp

    return wp.array(array.astype(np.float32), dtype=wp.vec3, device="cpu")


def _shared(array: np.ndarray) -> Any:
    """A warp array in the memory of a float32 one, or of a copy where it has gaps."""
    import warp as wp

    return wp.array(np.ascontiguousarray(array), device="cpu", copy=False)
