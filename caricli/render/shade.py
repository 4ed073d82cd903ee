"""Anti-aliased pictures of a mesh in soft studio light."""

import numpy as np

from caricli.render.curved_triangles import curved_triangles
from caricli.render.rasterise import depth_range, mesh_arrays, wp_mesh
from caricli.render.sky import light_received, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.warp_start import warp_start

CLAY = (206, 160, 136)
_LONGEST_EDGE, _MAX_FACES = 12.0, 150_000  # pixels; coarser meshes are rounded off before they are drawn


def shade(
    vertices,
    faces,
    width,
    height,
    colour=CLAY,
    supersample=3,
    vertex_colours=None,
    eyeballs=(),
    gaze=(0, 0, -1),
    visibility=None,
    rotation=None,
):
    """Draw a mesh: smooth normals, key, fill and rim light, soft shadows, anti-aliased borders.

    vertices: (V, 3), pixels, x right, y down, z into the picture; the centre of the top-left pixel is (0, 0). faces:
    (F, 3), counter-clockwise from outside; a triangle seen from inside lets the ray pass to what lies behind, and is
    drawn nearly black where nothing does. colour: sRGB, 0 to 255. supersample: its square is the number of rays per
    pixel where a border or a crease runs. vertex_colours: (V, 3), sRGB, 0 to 255, instead of `colour`. eyeballs: pairs
    of centre (3,) and radius in the frame of `vertices`, drawn as eyes that look along `gaze`. visibility, rotation:
    what `sky_visibility` saw before the mesh was turned by `rotation` (3, 3), for pictures of one mesh to share; both
    or neither.
    Returns (H, W, 4) uint8: sRGB, not premultiplied, and alpha from coverage.
    Raises InputError when a coordinate is not finite or an index is out of range.
    """
    kernels = warp_start()
    import warp as wp

    picture = np.zeros((height * width, 4), np.float32)
    points, triangles = mesh_arrays(vertices, faces)
    if not len(triangles) or not len(picture):
        return picture.astype(np.uint8).reshape(height, width, 4)
    normals = smooth_normals(points, triangles)
    if visibility is None:
        visibility, rotation = sky_visibility(points, triangles, normals), np.eye(3)
    ways = (np.array(kernels.KEY) @ rotation, np.array(kernels.FILL) @ rotation, None)
    light = light_received(visibility, normals @ rotation, ways)
    colours = np.broadcast_to(colour if vertex_colours is None else vertex_colours, points.shape)
    colours = _linear(np.asarray(colours, float))
    while _coarse(points, triangles):
        points, triangles, normals, (colours, light) = curved_triangles(points, triangles, normals, (colours, light))
    balls = np.array([[*centre, radius] for centre, radius in eyeballs], float).reshape(-1, 4)

    def on_device(array, dtype=wp.vec3):
        return wp.array(np.ascontiguousarray(array, np.float32), dtype=dtype, device="cpu")

    mesh = wp_mesh(points.astype(np.float32), triangles)
    scene = kernels.Scene()
    scene.mesh = mesh.id
    scene.start, scene.reach = depth_range(points)
    scene.normals, scene.colours, scene.light = on_device(normals), on_device(colours), on_device(light)
    scene.eyeballs, scene.gaze = on_device(balls, wp.vec4), wp.vec3(*(float(g) for g in gaze))
    centres = wp.zeros(len(picture), dtype=wp.vec4, device="cpu")
    wp.launch(kernels.centre_colour, len(picture), [scene, width], [centres], device="cpu")
    out = wp.array(picture, dtype=wp.vec4, device="cpu", copy=False)
    wp.launch(kernels.shaded_pixel, len(picture), [scene, width, height, supersample, centres], [out], device="cpu")
    return np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8).reshape(height, width, 4)


def _coarse(points, triangles):
    """Whether a tenth of the edges are so long in the picture that their corners would show."""
    if 4 * len(triangles) > _MAX_FACES:
        return False
    edges = np.linalg.norm((points[triangles] - points[np.roll(triangles, 1, axis=1)])[..., :2], axis=-1)
    return np.quantile(edges, 0.9) > _LONGEST_EDGE


def _linear(srgb):
    """From sRGB, 0 to 255, to linear light, 0 to 1."""
    x = np.clip(srgb / 255, 0, 1)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
