"""Pictures of a head from agreed sides."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from caricli.errors import InputError
from caricli.geometry.used_points import used_points
from caricli.render.in_parallel import in_parallel
from caricli.render.shade import Look, shade
from caricli.render.sky import mesh_sky
from caricli.structures import Mesh

VIEWS = {
    "front": 0.0,
    "three-quarter": -35.0,
    "profile": -90.0,
    "three-quarter-right": 35.0,
    "profile-right": 90.0,
    "behind": 180.0,
}
"""Turn of the head about its vertical axis in degrees; positive looks to the right of the picture."""

TO_PICTURE = np.diag([1.0, -1.0, -1.0])
"""From the face's axes to x right, y down, z into the picture, as the front view shows it."""

_FILL = 0.92  # of the picture's side: a border around the head


def render_views(
    mesh: Mesh,
    views: Iterable[str] = ("front", "three-quarter", "profile"),
    size: int = 512,
    look: Look | None = None,
) -> list[np.ndarray]:
    """Draw a head from several sides at one common scale.

    mesh: Mesh. views: keys of VIEWS. size: pixels, width and height of a picture. look: Look, its eyeballs in the face
    frame; gaze and rotation follow the view.
    Returns a list of (size, size, 4) uint8.
    Raises InputError when a view is not known.
    """
    views = list(views)
    unknown = [v for v in views if v not in VIEWS]
    if unknown:
        raise InputError(f"no view is called {unknown[0]!r}: expected some of {', '.join(VIEWS)}")
    return [*_turned(mesh, [VIEWS[v] for v in views], size, look or Look(), centred=True)]


def turntable(mesh: Mesh, frames: int, size: int = 512, look: Look | None = None) -> Iterator[np.ndarray]:
    """Draw a head turning once about its vertical axis, from the front.

    mesh, size, look: as in `render_views`. frames: how many pictures, evenly spread over the turn.
    Yields (size, size, 4) uint8.
    """
    return _turned(mesh, [360 * k / frames for k in range(frames)], size, look or Look(), centred=False)


def _turned(mesh: Mesh, angles: Sequence[float], size: int, look: Look, centred: bool) -> Iterator[np.ndarray]:
    """Pictures of a head turned by angles in degrees, each centred, or all about the middle of the head."""
    vertices = np.asarray(mesh.vertices, float)
    drawn = used_points(vertices, mesh.faces)
    middle = (drawn.min(0) + drawn.max(0)) / 2
    vertices = vertices - middle
    drawn = drawn - middle
    rotations = [TO_PICTURE @ turn_about_y(angle) for angle in angles]
    extents = [(v.min(0)[:2], v.max(0)[:2]) for v in (drawn @ r.T for r in rotations)]
    if centred:
        widest = max((np.ptp(e, axis=0).max() for e in extents), default=0)
    else:
        widest = 2 * max((np.abs(e).max() for e in extents), default=0)
    scale = _FILL * size / (widest or 1)
    visibility = mesh_sky(vertices, mesh.faces) if look.visibility is None else look.visibility
    ball = scale * max((radius for _, radius in look.eyeballs), default=0.0)
    coat = look.coat and look.coat.shrunk(scale * vertices, mesh.faces, ball)

    def draw(number: int) -> np.ndarray:
        rotation = rotations[number]
        low, high = extents[number]
        shift = np.array([*(-(low + high) / 2 if centred else (0, 0)), 0]) * scale + [(size - 1) / 2, (size - 1) / 2, 0]
        balls = [(scale * rotation @ (np.asarray(c) - middle) + shift, scale * r) for c, r in look.eyeballs]
        placed = {"eyeballs": balls, "gaze": rotation[:, 2], "visibility": visibility, "rotation": rotation}
        seen = replace(look, coat=coat, **placed)
        return shade(scale * vertices @ rotation.T + shift, mesh.faces, size, size, seen)

    return in_parallel(draw, range(len(angles)))


def turn_about_y(degrees: float) -> np.ndarray:
    """The rotation (3, 3) about the vertical axis that carries +Z towards +x."""
    c = np.cos(np.radians(degrees))
    s = np.sin(np.radians(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
