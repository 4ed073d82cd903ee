"""Which triangle is seen at each pixel."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.io.start_warp import start_warp
from caricli.render.in_parallel import in_parallel

_BAND = 192
"""Rows of a picture that are drawn by themselves, beside others."""


@dataclass(frozen=True)
class Raster:
    """What the pixels of a picture see of a mesh.

    face: (H, W) int32, -1 where nothing is seen.
    barycentric: (H, W, 3) float32, weights of the triangle's corners, zero where nothing is seen.
    depth: (H, W) float32, in the unit of the vertices, infinite where nothing is seen.
    """

    face: np.ndarray
    barycentric: np.ndarray
    depth: np.ndarray


def rasterise(vertices: np.ndarray, faces: np.ndarray, width: int, height: int) -> Raster:
    """Find the nearest triangle at the centre of every pixel.

    vertices: (V, 3), pixels, x right, y down, z into the picture (the smaller is the nearer); the centre of the
    top-left pixel is (0, 0). faces: (F, 3). Both sides of a triangle are seen. width, height: pixels.
    Returns a Raster.
    Raises InputError when a coordinate is not finite or an index is out of range.
    """
    points, triangles = mesh_arrays(vertices, faces)
    raster = Raster(
        np.full((height, width), -1, np.int32),
        np.zeros((height, width, 3), np.float32),
        np.full((height, width), np.inf, np.float32),
    )
    if len(triangles) and width and height:
        start_warp()
        import warp as wp

        from caricli.render.visibility.raster_kernel import draw_faces

        given = [(points, wp.vec3), (triangles, wp.int32)]
        drawn = [(raster.face, wp.int32), (raster.barycentric, wp.vec3), (raster.depth, wp.float32)]
        arrays: list[Any] = [wp.array(array, dtype=kind, device="cpu", copy=False) for array, kind in given + drawn]

        def draw(first: int) -> None:
            rows = wp.vec2i(first, min(first + _BAND, height))
            wp.launch(draw_faces, 1, [*arrays[:2], rows], arrays[2:], device="cpu")

        for _ in in_parallel(draw, range(0, height, _BAND)):
            pass
    return raster


def mesh_arrays(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Check a mesh and give it as float32 (V, 3) and int32 (F, 3), C-contiguous.

    vertices: (V, 3), any unit. faces: (F, 3).
    Raises InputError when a coordinate is not finite in single precision or an index is out of range.
    """
    with np.errstate(over="ignore"):
        points = np.ascontiguousarray(vertices, np.float32)
    triangles = np.ascontiguousarray(faces, np.int32)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"a mesh to draw needs vertices of shape (V, 3), found {points.shape}")
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise InputError(f"a mesh to draw needs faces of shape (F, 3), found {triangles.shape}")
    if not np.isfinite(points).all():
        raise InputError(
            f"a mesh to draw needs finite vertices, found {(~np.isfinite(points)).any(1).sum()} that are not"
        )
    if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
        raise InputError(
            f"a mesh of {len(points)} vertices needs faces between 0 and {len(points) - 1}, "
            f"found {triangles.min()} to {triangles.max()}"
        )
    return points, triangles


def wp_mesh(points: np.ndarray, triangles: np.ndarray) -> Any:
    """A warp mesh on the CPU from `mesh_arrays`' float32 points and int32 triangles."""
    import warp as wp

    return wp.Mesh(
        wp.array(points, dtype=wp.vec3, device="cpu"), wp.array(triangles.ravel(), dtype=wp.int32, device="cpu")
    )


def depth_range(points: np.ndarray) -> tuple[float, float]:
    """Where rays into the picture start, just before the nearest point, and how far they must reach.

    points: (V, 3), as `rasterise` takes them.
    """
    nearest = float(points[:, 2].min())
    farthest = float(points[:, 2].max())
    margin = 1 + 0.01 * (farthest - nearest)
    return nearest - margin, farthest - nearest + 2 * margin
