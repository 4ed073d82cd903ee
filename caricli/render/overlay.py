"""A fitted mesh and its landmarks over the picture they belong to."""

import numpy as np

from caricli.render.blend import over
from caricli.render.shade import CLAY, shade

# The polylines of the iBUG-68 landmarks: first, last, closed.
_IBUG = (
    (0, 16, False),
    (17, 21, False),
    (22, 26, False),
    (27, 30, False),
    (31, 35, False),
    (36, 41, True),
    (42, 47, True),
    (48, 59, True),
    (60, 67, True),
)


def overlay_mesh(image, mesh, camera, opacity=0.7, colour=CLAY, eyeballs=()):
    """Draw a mesh over a picture.

    image: (H, W, 3) uint8. mesh: Mesh in the face frame. camera: Camera. opacity: 0 to 1. colour, eyeballs: as in
    `shade`, the eyeballs in the face frame.
    Returns (H, W, 3) uint8.
    """
    balls = [(camera.place(centre), camera.scale * radius) for centre, radius in eyeballs]
    look = {"colour": colour, "eyeballs": balls, "gaze": camera.rotation[:, 2]}
    picture = shade(camera.place(mesh.vertices), mesh.faces, image.shape[1], image.shape[0], **look)
    return over(picture, image, opacity)


def draw_landmarks(image, points, colour=(0, 200, 120), radius=None, lines=True, hollow=False):
    """Draw landmarks as dots, those of iBUG-68 joined by thin lines.

    image: (H, W, 3) uint8. points: (L, 2), pixels; rows with NaN are left out, and the lines to them. colour: sRGB, 0
    to 255. radius: pixels; 0.6 % of the picture's shorter side when absent. lines: whether to join them. hollow:
    circles instead of dots, to tell two sets of landmarks apart.
    Returns (H, W, 3) uint8.
    """
    import cv2

    points = np.asarray(points, float)
    picture = np.ascontiguousarray(image).copy()
    radius = max(1.5, 0.006 * min(image.shape[:2])) if radius is None else radius
    thickness = max(1, round(radius / 2.5))
    colour = tuple(int(c) for c in colour)
    shift, far = 4, 1 << 14
    # OpenCV draws at fractions of a pixel given in 1/16; far points would overflow its integers.
    fixed = np.rint(np.clip(np.where(np.isfinite(points), points, 0), -far, far) * 2**shift).astype(int)
    known = np.isfinite(points).all(1)
    if lines and len(points) >= 68:
        for first, last, closed in _IBUG:
            ids = [*range(first, last + 1), *([first] if closed else [])]
            for a, b in zip(ids, ids[1:], strict=False):
                if known[a] and known[b]:
                    cv2.line(picture, fixed[a].tolist(), fixed[b].tolist(), colour, thickness, cv2.LINE_AA, shift)
    for k in np.flatnonzero(known):
        cv2.circle(
            picture,
            fixed[k].tolist(),
            round(radius * 2**shift),
            colour,
            thickness if hollow else -1,
            cv2.LINE_AA,
            shift,
        )
    return picture
