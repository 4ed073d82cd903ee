"""Pictures of a rig's frames with one camera for all of them."""

import numpy as np

from caricli.errors import InputError
from caricli.render.blend import over
from caricli.render.curved_triangles import split_long_edges
from caricli.render.sample_texture import sample_texture_finely
from caricli.render.shade import CLAY, Look, shade
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import TO_PICTURE, VIEWS, turn_about_y
from caricli.structures import Material, Rig

EYE_WHITE = (232, 228, 222)
PAPER = (255, 255, 255)
_FILL = 0.82  # of the picture: jaws drop and heads turn
_PLAIN_EDGE = 12.0  # pixels; nine tenths of a finer mesh's edges are shorter
_PAINTED_EDGE = 2.0  # pixels; colours of a picture change from vertex to vertex


def neutral_sky(rig: Rig) -> np.ndarray:
    """What the vertices of the neutral face see of the sky, for frames to share: finding it takes most of the time.

    Returns an array for ``draw_rig``.
    """
    return sky_visibility(rig.neutral.astype(float), rig.faces, smooth_normals(rig.neutral, rig.faces))


def draw_rig(
    rig: Rig, vertices: np.ndarray, view: str = "front", size: int = 512, sky: np.ndarray | None = None
) -> np.ndarray:
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
    rotation = TO_PICTURE @ turn_about_y(VIEWS[view])
    neutral = rig.neutral @ rotation.T
    low = neutral.min(0)
    high = neutral.max(0)
    scale = _FILL * size / ((high - low)[:2].max() or 1)
    normals = smooth_normals(vertices, rig.faces)
    visibility = sky_visibility(vertices, rig.faces, normals) if sky is None else sky
    middle = np.array([(size - 1) / 2, (size - 1) / 2, 0])
    points = scale * (vertices @ rotation.T - (low + high) / 2) + middle
    points, faces, colours, visibility = _painted(rig, points, normals @ rotation.T, visibility)
    look = Look(vertex_colours=colours, visibility=visibility, rotation=rotation)
    return over(shade(points, faces, size, size, look), PAPER)


def _painted(rig: Rig, points: np.ndarray, normals: np.ndarray, visibility: np.ndarray) -> tuple[np.ndarray, ...]:
    """Points (W, 3), faces (F, 3), sRGB colours (W, 3) and visibility of the materials, one after the other."""
    if rig.materials is None:
        return points, rig.faces, np.broadcast_to(CLAY, points.shape), visibility
    uv_faces = rig.faces if rig.mesh.uvs is None else rig.mesh.uv_faces
    materials = rig.triangle_materials
    parts = []
    count = 0
    for material, plain in ((Material.SKIN, CLAY), (Material.EYE, EYE_WHITE)):
        corners = np.stack([rig.faces[materials == material], uv_faces[materials == material]], -1).reshape(-1, 2)
        if not len(corners):
            continue
        # Along a seam a vertex has two places in the picture, so it becomes two.
        pairs, faces = np.unique(corners, axis=0, return_inverse=True)
        at = pairs[:, 0]
        image = None if rig.mesh.uvs is None else rig.picture(material)
        uvs = np.zeros((len(at), 2)) if rig.mesh.uvs is None else rig.mesh.uvs[pairs[:, 1]]
        longest = _PLAIN_EDGE if image is None else _PAINTED_EDGE
        carried = (uvs, visibility[at])
        places, faces, _, (uvs, seen) = split_long_edges(
            points[at], faces.reshape(-1, 3), normals[at], carried, longest
        )
        colours = np.broadcast_to(plain, places.shape) if image is None else sample_texture_finely(image, uvs)
        parts.append((places, faces + count, colours, seen))
        count += len(places)
    points, faces, colours, seen = (np.concatenate(part) for part in zip(*parts, strict=True))
    return points, faces, colours, seen.astype(np.float32)
