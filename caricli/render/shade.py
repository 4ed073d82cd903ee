"""Soft studio shading of a mesh in pixels."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from caricli.render.coat import NO_PICTURE, Coat
from caricli.render.curved_triangles import split_long_edges
from caricli.render.rasterise import depth_range, mesh_arrays, wp_mesh
from caricli.render.sky import light_received, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.warp_start import warp_start
from caricli.structures import Material
from caricli.structures.materials import FINISHES
from caricli.structures.pictures import PICTURED

CLAY = FINISHES[Material.SKIN].colour
_LONGEST_EDGE = 12.0  # pixels; coarser meshes would show their corners and are rounded off before they are drawn


@dataclass(frozen=True, eq=False)
class Look:
    """How a mesh is drawn.

    colour: sRGB, 0 to 255.
    vertex_colours: (V, 3) sRGB, 0 to 255, instead of ``colour``; or None.
    coat: Coat of the mesh, with colours of its own where it has pictures; or None.
    supersample: its square is the number of rays per pixel where a border or a crease runs.
    eyeballs: pairs of centre (3,) and radius in the frame of the vertices, drawn as eyes.
    gaze: (3,) unit, where the eyes look.
    visibility: (V, D) what `sky_visibility` saw of the mesh before it was turned, for pictures of one mesh to share; or
    None, to look around anew.
    rotation: (3, 3), how the mesh was turned since; given where ``visibility`` is.
    """

    colour: Sequence[float] = CLAY
    vertex_colours: np.ndarray | None = None
    coat: Coat | None = None
    supersample: int = 3
    eyeballs: Sequence[tuple[np.ndarray, float]] = ()
    gaze: Sequence[float] | np.ndarray = (0, 0, -1)
    visibility: np.ndarray | None = None
    rotation: np.ndarray | None = None


def shade(points: np.ndarray, faces: np.ndarray, width: int, height: int, look: Look | None = None) -> np.ndarray:
    """Draw a mesh: smooth normals, key, fill and rim light, soft shadows, anti-aliased borders.

    points: (V, 3) pixels, x right, y down, z into the picture; the centre of the top-left pixel is (0, 0). faces:
    (F, 3), counter-clockwise from outside; a triangle seen from inside lets the ray pass to what lies behind, and is
    drawn nearly black where nothing does. width, height: pixels. look: Look, the usual one where there is none.
    Returns (H, W, 4) uint8: sRGB, not premultiplied, and alpha from coverage.
    Raises InputError when a coordinate is not finite or an index is out of range.
    """
    look = look or Look()
    kernels = warp_start()
    import warp as wp

    picture = np.zeros((height * width, 4), np.float32)
    points, triangles = mesh_arrays(points, faces)
    if not len(triangles) or not len(picture):
        return picture.astype(np.uint8).reshape(height, width, 4)
    normals = smooth_normals(points, triangles)
    light = _light(kernels, points, triangles, normals, look)
    colours = np.broadcast_to(look.colour if look.vertex_colours is None else look.vertex_colours, points.shape)
    carried: list[np.ndarray] = [_linear(np.asarray(colours, float)), light]
    pictures: Sequence[np.ndarray] = [NO_PICTURE] * len(PICTURED)
    if look.coat is not None:
        largest = max((radius for _, radius in look.eyeballs), default=0.0)
        pictures = look.coat.shrunk(points, triangles, largest)
        at, triangles, places = look.coat.cut(triangles)
        points = points[at]
        normals = normals[at]
        carried = [*(array[at] for array in carried), places]
    points, triangles, normals, finer = split_long_edges(points, triangles, normals, carried, _LONGEST_EDGE)
    mesh = wp_mesh(points.astype(np.float32), triangles)
    scene = kernels.Scene()
    scene.mesh = mesh.id
    scene.start, scene.reach = depth_range(points)
    places = finer[2] if look.coat is not None else np.zeros((0, 3))
    arrays = (normals, *finer[:2], places)
    scene.normals, scene.colours, scene.light, scene.places = (_on_device(array, wp.vec3) for array in arrays)
    for name, worn in zip(PICTURED.values(), pictures, strict=True):
        setattr(scene, name, wp.array(worn, dtype=wp.uint8, device="cpu", copy=False))
    balls = [[*centre, radius] for centre, radius in look.eyeballs]
    scene.eyeballs = _on_device(np.array(balls, float).reshape(-1, 4), wp.vec4)
    scene.gaze = wp.vec3(*(float(g) for g in look.gaze))
    centres = wp.zeros(len(picture), dtype=wp.vec4, device="cpu")
    wp.launch(kernels.centre_colour, len(picture), [scene, width], [centres], device="cpu")
    out: Any = wp.array(picture, dtype=wp.vec4, device="cpu", copy=False)
    given = [scene, width, height, look.supersample, centres]
    wp.launch(kernels.shaded_pixel, len(picture), given, [out], device="cpu")
    return np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8).reshape(height, width, 4)


def _light(
    kernels: ModuleType, points: np.ndarray, triangles: np.ndarray, normals: np.ndarray, look: Look
) -> np.ndarray:
    """Shares (V, 3) of key light, fill light and sky that reach the vertices."""
    if look.visibility is None:
        visibility = sky_visibility(points, triangles, normals)
        rotation = np.eye(3)
    else:
        visibility = look.visibility
        rotation = np.asarray(look.rotation)
    ways = (np.array(kernels.KEY) @ rotation, np.array(kernels.FILL) @ rotation, None)
    return light_received(visibility, normals @ rotation, ways)


def _on_device(array: np.ndarray, dtype: type) -> Any:
    import warp as wp

    return wp.array(np.ascontiguousarray(array, np.float32), dtype=dtype, device="cpu")


def _linear(srgb: np.ndarray) -> np.ndarray:
    """From sRGB, 0 to 255, to linear light, 0 to 1."""
    x = np.clip(srgb / 255, 0, 1)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
