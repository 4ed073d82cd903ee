"""A fitted mesh and its landmarks over the picture they belong to."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from caricli.render.pixels.blend import over
from caricli.render.shade import Look, shade
from caricli.structures import Camera, Mesh
from caricli.structures.landmarks import COUNT, POLYLINES, RINGS
from caricli.structures.materials import HEAD_PARTS

_DOT = 0.006  # of the picture's shorter side: radius of a landmark
_SMALLEST_DOT = 1.5  # pixels
_FRACTION_BITS = 4  # OpenCV takes places in sixteenths of a pixel
_FARTHEST = 1 << 14  # pixels; farther points, in sixteenths, could overflow OpenCV's integers


def overlay_mesh(
    image: np.ndarray,
    mesh: Mesh,
    camera: Camera,
    opacity: float = 0.7,
    look: Look = Look(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """Draw a mesh over a picture, but for what is below its neck: the picture shows what is there.

    image: (H, W, 3) uint8. mesh: Mesh in the face frame. camera: Camera. opacity: 0 to 1. look: Look of the mesh, its
    eyeballs in the face frame.
    Returns (H, W, 3) uint8.
    """
    faces = mesh.faces
    if look.coat is not None:
        head = ~np.isin(look.coat.materials, HEAD_PARTS["bust"])
        faces = faces[head]
        coat = replace(look.coat, uv_faces=look.coat.uv_faces[head], materials=look.coat.materials[head])
        look = replace(look, coat=coat)
    balls = [(camera.place(centre), camera.scale * radius) for centre, radius in look.eyeballs]
    look = replace(look, eyeballs=balls, gaze=camera.rotation[:, 2])
    height, width = image.shape[:2]
    return over(shade(camera.place(mesh.vertices), faces, width, height, look), image, opacity)


def draw_landmarks(
    image: np.ndarray,
    points: np.ndarray | Sequence[Sequence[float]],
    colour: Sequence[int] = (0, 200, 120),
    radius: float | None = None,
    lines: bool = True,
    hollow: bool = False,
) -> np.ndarray:
    """Draw landmarks as dots, those of iBUG-68 joined by thin lines.

    image: (H, W, 3) uint8. points: (L, 2), pixels; rows with NaN are left out, and the lines to them. colour: sRGB, 0
    to 255. radius: pixels; 0.6 % of the picture's shorter side when absent. lines: whether to join them. hollow:
    circles instead of dots, to tell two sets of landmarks apart.
    Returns (H, W, 3) uint8.
    """
    import cv2

    points = np.asarray(points, float)
    picture = np.ascontiguousarray(image).copy()
    radius = max(_SMALLEST_DOT, _DOT * min(image.shape[:2])) if radius is None else radius
    thickness = max(1, round(radius / 2.5))
    ink = tuple(int(c) for c in colour)
    near = np.clip(np.where(np.isfinite(points), points, 0), -_FARTHEST, _FARTHEST)
    fixed = np.rint(near * 2**_FRACTION_BITS).astype(int)
    shown = np.isfinite(points).all(1)
    if lines and len(points) >= COUNT:
        for a, b in _edges():
            if shown[a] and shown[b]:
                ends = fixed[a].tolist(), fixed[b].tolist()
                cv2.line(picture, *ends, ink, thickness, cv2.LINE_AA, _FRACTION_BITS)
    filled = thickness if hollow else cv2.FILLED
    size = round(radius * 2**_FRACTION_BITS)
    for k in np.flatnonzero(shown):
        cv2.circle(picture, fixed[k].tolist(), size, ink, filled, cv2.LINE_AA, _FRACTION_BITS)
    return picture


def _edges() -> list[tuple[int, int]]:
    """Pairs of landmarks of iBUG-68 that a line joins, in the order they are drawn."""
    paths = [*map(list, POLYLINES), *([*ring, ring[0]] for ring in RINGS)]
    return [edge for path in paths for edge in zip(path, path[1:], strict=False)]
