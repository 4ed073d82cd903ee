"""Pictures of a head from agreed sides."""

import numpy as np

from caricli.errors import InputError
from caricli.render.shade import CLAY, shade
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals

# Turn of the head about its vertical axis in degrees; positive looks to the right of the picture.
VIEWS = {"front": 0.0, "three-quarter": -35.0, "profile": -90.0, "three-quarter-right": 35.0, "profile-right": 90.0}
_TO_PICTURE = np.diag([1.0, -1.0, -1.0])


def render_views(vertices, faces, views=("front", "three-quarter", "profile"), size=512, **looks):
    """Draw a head from several sides at one common scale.

    vertices: (V, 3), face frame: Y up, +Z out of the face, +x the subject's left. faces: (F, 3). views: keys of VIEWS.
    size: pixels, width and height of a picture. looks: of `shade` (colour, vertex_colours, supersample, eyeballs,
    visibility); the eyeballs are in the face frame.
    Returns a list of (size, size, 4) uint8.
    Raises InputError when a view is not known.
    """
    unknown = [v for v in views if v not in VIEWS]
    if unknown:
        raise InputError(f"no view is called {unknown[0]!r}: expected some of {', '.join(VIEWS)}")
    return _turned(vertices, faces, [VIEWS[v] for v in views], size, centred=True, **looks)


def turntable(vertices, faces, frames, size=512, **looks):
    """Draw a head turning once about its vertical axis, from the front.

    vertices, faces, size, looks: as in `render_views`. frames: how many pictures, evenly spread over the turn.
    Returns a list of (size, size, 4) uint8.
    """
    return _turned(vertices, faces, [360 * k / frames for k in range(frames)], size, centred=False, **looks)


def _turned(
    vertices,
    faces,
    angles,
    size,
    centred,
    colour=CLAY,
    supersample=3,
    vertex_colours=None,
    eyeballs=(),
    visibility=None,
):
    vertices, faces = np.asarray(vertices, float), np.asarray(faces)
    middle = (vertices.min(0) + vertices.max(0)) / 2
    vertices = vertices - middle
    rotations = [_TO_PICTURE @ _turn(angle) for angle in angles]
    extents = [(v.min(0)[:2], v.max(0)[:2]) for v in (vertices @ r.T for r in rotations)]
    if centred:
        widest = max((np.ptp(e, axis=0).max() for e in extents), default=0)
    else:
        widest = 2 * max((np.abs(e).max() for e in extents), default=0)
    scale = 0.92 * size / (widest or 1)
    if visibility is None:
        visibility = sky_visibility(vertices, faces, smooth_normals(vertices, faces))
    pictures = []
    for rotation, (low, high) in zip(rotations, extents, strict=True):
        shift = np.array([*(-(low + high) / 2 if centred else (0, 0)), 0]) * scale + [(size - 1) / 2, (size - 1) / 2, 0]
        balls = [(scale * rotation @ (np.asarray(c) - middle) + shift, scale * r) for c, r in eyeballs]
        pictures.append(
            shade(
                scale * vertices @ rotation.T + shift,
                faces,
                size,
                size,
                colour,
                supersample,
                vertex_colours,
                balls,
                rotation[:, 2],
                visibility,
                rotation,
            )
        )
    return pictures


def _turn(degrees):
    """Rotation about the vertical axis that carries +Z towards +x."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
