"""Pictures of a rig's frames with one camera for all of them."""

import numpy as np

from caricli.errors import InputError
from caricli.render.blend import over
from caricli.render.curved_triangles import curved_triangles
from caricli.render.shade import CLAY, shade
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import VIEWS
from caricli.structures import Material

EYE_WHITE = (232, 228, 222)
PAPER = (255, 255, 255)
_FILL = 0.82  # of the picture: jaws drop and heads turn
_PLAIN_EDGE, _PAINTED_EDGE = 12.0, 2.0  # pixels; nine tenths of a finer mesh's edges are shorter
_MAX_FACES = 150_000


def neutral_sky(rig):
    """What the vertices of the neutral face see of the sky, for frames to share: finding it takes most of the time.

    Returns an array for ``draw_rig``.
    """
    return sky_visibility(rig.neutral.astype(float), rig.faces, smooth_normals(rig.neutral, rig.faces))


def draw_rig(rig, vertices, view="front", size=512, sky=None):
    """Draw one frame of a rig; the camera depends on the neutral face alone, so that frames follow each other calmly.

    Painted materials are sampled at the vertices of a finer mesh; without a picture skin is clay and eyes are white.
    rig: Rig. vertices: (V, 3), metres, of this frame. view: a key of VIEWS. size: pixels, width and height. sky:
    of ``neutral_sky``, or None to look around anew.
    Returns (size, size, 3) uint8 on white.
    Raises InputError when the view is not known or the vertices are not the rig's.
    """
    if view not in VIEWS:
        raise InputError(f"no view is called {view!r}: expected one of {', '.join(VIEWS)}")
    vertices = np.asarray(vertices, float)
    if vertices.shape != rig.neutral.shape:
        raise InputError(f"a frame of this rig needs vertices of shape {rig.neutral.shape}, found {vertices.shape}")
    c, s = np.cos(np.radians(VIEWS[view])), np.sin(np.radians(VIEWS[view]))
    rotation = np.array([[c, 0, s], [0, -1, 0], [s, 0, -c]])
    neutral = rig.neutral @ rotation.T
    low, high = neutral.min(0), neutral.max(0)
    scale = _FILL * size / ((high - low)[:2].max() or 1)
    normals = smooth_normals(vertices, rig.faces)
    visibility = sky_visibility(vertices, rig.faces, normals) if sky is None else sky
    middle = np.array([(size - 1) / 2, (size - 1) / 2, 0])
    points = scale * (vertices @ rotation.T - (low + high) / 2) + middle
    points, faces, colours, visibility = _painted(rig, points, normals @ rotation.T, visibility)
    look = {"vertex_colours": colours, "visibility": visibility, "rotation": rotation}
    return over(shade(points, faces, size, size, **look), PAPER)


def _painted(rig, vertices, normals, visibility):
    """Vertices (W, 3), faces (F, 3), sRGB colours (W, 3) and visibility of the materials, one after the other."""
    if rig.materials is None:
        colour = np.broadcast_to(CLAY, vertices.shape)
        return vertices, rig.faces, colour, visibility
    owner = rig.triangle_materials
    faces = rig.mesh.faces
    uv_faces = faces if rig.mesh.uvs is None else rig.mesh.uv_faces
    parts, count = [], 0
    for material, image, plain in ((Material.SKIN, rig.texture, CLAY), (Material.EYE, rig.eye_texture, EYE_WHITE)):
        corners = np.stack([faces[owner == material], uv_faces[owner == material]], -1).reshape(-1, 2)
        if not len(corners):
            continue
        # Along a seam a vertex has two places in the picture, so it becomes two.
        pairs, triangles = np.unique(corners, axis=0, return_inverse=True)
        triangles, at = triangles.reshape(-1, 3), pairs[:, 0]
        painted = image is not None and rig.mesh.uvs is not None
        points, ways, seen = vertices[at], normals[at], visibility[at]
        uvs = rig.mesh.uvs[pairs[:, 1]] if painted else np.zeros((len(at), 2))
        while _coarse(points, triangles, _PAINTED_EDGE if painted else _PLAIN_EDGE):
            points, triangles, ways, (uvs, seen) = curved_triangles(points, triangles, ways, (uvs, seen))
        colours = _sampled(image, uvs) if painted else np.broadcast_to(plain, points.shape)
        parts.append((points, triangles + count, colours, seen))
        count += len(points)
    points, triangles, colours, seen = (np.concatenate(part) for part in zip(*parts, strict=True))
    return points, triangles, colours, seen.astype(np.float32)


def _coarse(points, triangles, longest):
    """Whether a tenth of the edges are longer than so many pixels, and a finer mesh is not too large."""
    if 4 * len(triangles) > _MAX_FACES:
        return False
    edges = np.linalg.norm((points[triangles] - points[np.roll(triangles, 1, axis=1)])[..., :2], axis=-1)
    return np.quantile(edges, 0.9) > longest


def _sampled(image, uvs):
    """Colours (T, 3) of a picture (H, W, 3), the top row first, at UVs (T, 2), origin bottom left; bilinear."""
    height, width = image.shape[:2]
    x = np.clip(uvs[:, 0] * width - 0.5, 0, width - 1)
    y = np.clip((1 - uvs[:, 1]) * height - 0.5, 0, height - 1)
    column, row = (np.minimum(a.astype(int), n - 1) for a, n in ((x, width), (y, height)))
    right, below = np.minimum(column + 1, width - 1), np.minimum(row + 1, height - 1)
    x, y = (x - column)[:, None], (y - row)[:, None]
    top = image[row, column] * (1 - x) + image[row, right] * x
    return top * (1 - y) + (image[below, column] * (1 - x) + image[below, right] * x) * y
