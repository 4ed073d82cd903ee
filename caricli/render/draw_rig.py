"""Pictures of a rig's frames with one camera for all of them."""

import numpy as np

from caricli.errors import InputError
from caricli.render.blend import over
from caricli.render.coat import rig_coat
from caricli.render.face_look import plain_colours
from caricli.render.shade import Look, shade
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import TO_PICTURE, VIEWS, turn_about_y
from caricli.structures import Rig

PAPER = (255, 255, 255)
_FILL = 0.82  # of the picture: jaws drop and heads turn
_HIDDEN = 0.25  # of the sky of a free vertex; what sees less at rest, as the mouth does, may come out


def neutral_sky(rig: Rig) -> np.ndarray:
    """What the vertices of the neutral face see of the sky, for frames to share: finding it takes most of the time.

    Returns an array for ``draw_rig``.
    """
    return sky_visibility(rig.neutral.astype(float), rig.faces, smooth_normals(rig.neutral, rig.faces))


def draw_rig(
    rig: Rig, vertices: np.ndarray, view: str = "front", size: int = 512, sky: np.ndarray | None = None
) -> np.ndarray:
    """Draw one frame of a rig; the camera depends on the neutral face alone, so that frames follow each other calmly.

    Without a picture skin is clay and eyes are white. What is hidden in the neutral face looks around anew, so that an
    open mouth shows its wall.

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
    visibility = sky_visibility(vertices, rig.faces, normals) if sky is None else _seen(rig, vertices, normals, sky)
    middle = np.array([(size - 1) / 2, (size - 1) / 2, 0])
    points = scale * (vertices @ rotation.T - (low + high) / 2) + middle
    coat = rig_coat(rig)
    look = Look(
        vertex_colours=plain_colours(rig.mesh, rig.triangle_materials),
        coat=coat,
        visibility=visibility,
        rotation=rotation,
    )
    return over(shade(points, rig.faces, size, size, look), PAPER)


def _seen(rig: Rig, vertices: np.ndarray, normals: np.ndarray, sky: np.ndarray) -> np.ndarray:
    """What vertices (V, 3) of a frame see of the sky: that of the neutral face, but for what is hidden there."""
    # Half of the directions are behind a surface.
    hidden = np.flatnonzero(sky.mean(1) < _HIDDEN / 2)
    visibility = np.array(sky)
    visibility[hidden] = sky_visibility(vertices, rig.faces, normals, hidden)
    return visibility
