"""Warp kernels for single points; imported by `seen_points` alone, after warp has been started."""

# mypy: ignore-errors
# Warp reads the annotations as types of its own language, which no checker of Python knows.

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel
def depth_before(
    mesh: wp.uint64,
    start: float,
    points: wp.array(dtype=wp.vec3),
    clearance: wp.array(dtype=wp.float32),
):
    """How far before a point the mesh is in the way of somebody who looks there; negative where nothing is."""
    i = wp.tid()
    point = points[i]
    hit = wp.mesh_query_ray(mesh, wp.vec3(point[0], point[1], start), wp.vec3(0.0, 0.0, 1.0), point[2] - start)
    if hit.result:
        clearance[i] = point[2] - (start + hit.t)
    else:
        clearance[i] = -1.0
