"""Soft studio shading of a mesh in pixels."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.geometry.comb_hair import CombedHair
from caricli.render.coat import Coat
from caricli.render.curved_triangles import split_long_edges
from caricli.render.lights import FILL, KEY
from caricli.render.load_kernels import load_kernels
from caricli.render.pixels.srgb import to_linear
from caricli.render.sky import DIRECTIONS, key_directions, light_received, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import depth_range, mesh_arrays, wp_mesh
from caricli.render.visibility.seen_vertices import seen_vertices
from caricli.structures import Material, Mesh, Pictures
from caricli.structures.materials import FINISHES

CLAY = FINISHES[Material.SKIN].colour
_NO_PICTURE = np.zeros((0, 0, 3), np.uint8)
_LONGEST_EDGE = 12.0  # pixels; coarser meshes would show their corners and are rounded off before they are drawn
_SOFTNESS = dict.fromkeys((Material.SKIN, Material.GUMS, Material.TONGUE, Material.BUST), 1.0) | {Material.TEETH: 0.5}
_WETNESS = {Material.TEETH: 1.0, Material.GUMS: 0.7, Material.TONGUE: 0.7}


@dataclass(frozen=True, eq=False)
class Look:
    """How a mesh is drawn.

    colour: sRGB, 0 to 255.
    vertex_colours: (V, 3) sRGB, 0 to 255, instead of ``colour``; or None.
    coat: Coat of the mesh, with colours of its own where it has pictures; or None.
    hair: CombedHair of the mesh; or None where it is shaded as its surface is.
    supersample: its square is the number of rays per pixel where a border or a crease runs.
    eyeballs: pairs of centre (3,) and radius in the frame of the vertices, drawn as eyes.
    gaze: (3,) unit, where the eyes look.
    visibility: (V, D) what `sky_visibility` saw of the mesh before it was turned, for pictures of one mesh to share; or
    None, to look around anew.
    key: (V, D) what it saw of the key light in the `key_directions` of this picture, where ``visibility`` is; or None.
    rotation: (3, 3), how the mesh was turned since; given where ``visibility`` is.
    hidden: (V,) bool, vertices that look around anew nevertheless where they are seen, where ``key`` is; or None.
    """

    colour: Sequence[float] = CLAY
    vertex_colours: np.ndarray | None = None
    coat: Coat | None = None
    hair: CombedHair | None = None
    supersample: int = 3
    eyeballs: Sequence[tuple[np.ndarray, float]] = ()
    gaze: Sequence[float] | np.ndarray = (0, 0, -1)
    visibility: np.ndarray | None = None
    key: np.ndarray | None = None
    rotation: np.ndarray | None = None
    hidden: np.ndarray | None = None


def shade(points: np.ndarray, faces: np.ndarray, width: int, height: int, look: Look | None = None) -> np.ndarray:
    """Draw a mesh: smooth normals, key, fill and rim light, soft shadows, anti-aliased borders.

    points: (V, 3) pixels, x right, y down, z into the picture; the centre of the top-left pixel is (0, 0). faces:
    (F, 3), counter-clockwise from outside; a triangle seen from inside lets the ray pass to what lies behind, and is
    drawn nearly black where nothing does. width, height: pixels. look: Look, the usual one where there is none.
    Returns (H, W, 4) uint8: sRGB, not premultiplied, and alpha from coverage.
    Raises InputError when a coordinate is not finite or an index is out of range.
    """
    look = look or Look()
    kernels = load_kernels()
    import warp as wp

    picture = np.zeros((height * width, 4), np.float32)
    points, triangles = mesh_arrays(points, faces)
    if not len(triangles) or not len(picture):
        return picture.astype(np.uint8).reshape(height, width, 4)
    placed = Mesh(points, triangles)
    normals = smooth_normals(points, triangles)
    shaded = normals if look.hair is None else look.hair.normals(normals)
    shine = np.ones(len(points)) if look.hair is None else look.hair.shine
    carried = [shaded, _light(placed, shaded, width, height, look), shine]
    scene, mesh = _scene(placed, normals, carried, look)
    scene.mesh = mesh.id
    centres = wp.zeros(len(picture), dtype=kernels.Sample, device="cpu")
    wp.launch(kernels.centre_sample, len(picture), [scene, width], [centres], device="cpu")
    out: Any = wp.array(picture, dtype=wp.vec4, device="cpu", copy=False)
    given = [scene, width, height, look.supersample, centres]
    wp.launch(kernels.shaded_pixel, len(picture), given, [out], device="cpu")
    return np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8).reshape(height, width, 4)


def _light(mesh: Mesh, normals: np.ndarray, width: int, height: int, look: Look) -> np.ndarray:
    """Shares (V, 3) of key light, fill light and sky that reach the vertices; only those that are seen look around."""
    rotation = np.eye(3) if look.rotation is None else np.asarray(look.rotation)
    normals = normals @ rotation
    around = len(DIRECTIONS)
    directions = np.concatenate([DIRECTIONS, key_directions(KEY) @ rotation])
    sight = np.zeros((len(normals), len(directions)), np.float32)
    unsure = np.ones(len(normals), bool)
    first = 0
    if look.visibility is not None:
        sight[:, :around] = look.visibility
        first = around
    if look.key is not None:
        sight[:, around:] = look.key
        unsure = np.zeros(len(normals), bool) if look.hidden is None else look.hidden
        first = 0
    if unsure.any():
        anew = np.flatnonzero(unsure & seen_vertices(mesh.vertices, mesh.faces, width, height))
        sight[anew, first:] = sky_visibility(mesh.vertices @ rotation, mesh.faces, normals, anew, directions[first:])
    wide = light_received(sight[:, :around], normals, DIRECTIONS, [FILL @ rotation, None])
    key = light_received(sight[:, around:], normals, directions[around:], [None])
    return np.column_stack([key, wide])


def _scene(mesh: Mesh, normals: np.ndarray, carried: list[np.ndarray], look: Look) -> tuple[Any, Any]:
    """The kernels' Scene of a Mesh in pixels, and warp's mesh, which must outlive it.

    normals: (V, 3) of its surface. carried: of its vertices, the normals that they are shaded with, their light, and
    how much strands shine.
    """
    kernels = load_kernels()
    import warp as wp

    points = mesh.vertices
    triangles = mesh.faces
    colours = np.broadcast_to(look.colour if look.vertex_colours is None else look.vertex_colours, points.shape)
    carried = [*carried, to_linear(np.asarray(colours, float) / 255)]
    places = np.zeros((len(points), 3))
    pictures = Pictures()
    if look.coat is not None:
        largest = max((radius for _, radius in look.eyeballs), default=0.0)
        pictures = look.coat.shrunk(points, triangles, largest).pictures
        at, triangles, places = look.coat.cut(triangles)
        points = points[at]
        normals = normals[at]
        carried = [array[at] for array in carried]
    points, triangles, normals, finer = split_long_edges(points, triangles, normals, [*carried, places], _LONGEST_EDGE)
    shaded, light, shine, colours, places = finer
    if look.hair is None:
        # Of unit length between vertices, too.
        shaded = normals
    scene = kernels.Scene()
    scene.start, scene.reach = depth_range(points)
    arrays = (shaded, colours, light, places)
    scene.normals, scene.colours, scene.light, scene.places = (_on_device(array, wp.vec3) for array in arrays)
    scene.shine = _on_device(shine, float)
    for name, worn in pictures.items():
        texels = _NO_PICTURE if worn is None else np.ascontiguousarray(worn)
        setattr(scene, name, wp.array(texels, dtype=wp.uint8, device="cpu", copy=False))
    scene.finishes = _on_device(np.array([_finish(material, pictures) for material in Material]), wp.vec3)
    balls = [[*centre, radius] for centre, radius in look.eyeballs]
    scene.eyeballs = _on_device(np.array(balls, float).reshape(-1, 4), wp.vec4)
    scene.gaze = wp.vec3(*(float(g) for g in look.gaze))
    return scene, wp_mesh(points.astype(np.float32), triangles)


def _finish(material: Material, pictures: Pictures) -> tuple[float, float, float]:
    """Roughness of a material, how far light wanders under its surface, and how wet it is, 0 to 1.

    pictures: what is worn; where they have no colour light gets none under the skin.
    """
    soft = pictures.coloured * _SOFTNESS.get(material, 0.0)
    return FINISHES[material].roughness, soft, _WETNESS.get(material, 0.0)


def _on_device(array: np.ndarray, dtype: type) -> Any:
    import warp as wp

    return wp.array(np.ascontiguousarray(array, np.float32), dtype=dtype, device="cpu")
