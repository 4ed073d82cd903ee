"""A fitted mesh and its landmarks over the picture they belong to."""

import numpy as np

from caricli.errors import InputError
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


def overlay_mesh(
    image, vertices, faces, camera_scale, camera_rotation, camera_translation, opacity=0.7, colour=CLAY, eyeballs=()
):
    """Draw a mesh over a picture through a scaled orthographic camera: q = s R[:2] p + t.

    image: (H, W, 3) uint8. vertices: (V, 3), face frame. faces: (F, 3). camera_scale: pixels per unit.
    camera_rotation: (3, 3), proper, face frame to OpenCV's (x right, y down, z into the picture). camera_translation:
    (2,), pixels; (0, 0) is the centre of the top-left pixel. opacity: 0 to 1. colour, eyeballs: as in `shade`, the
    eyeballs in the face frame.
    Returns (H, W, 3) uint8.
    Raises InputError when the camera is not one.
    """
    rotation, translation = np.asarray(camera_rotation, float), np.asarray(camera_translation, float)
    if (
        rotation.shape != (3, 3)
        or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3)
        or (np.linalg.det(rotation) < 0)
    ):
        raise InputError("camera_rotation must be a proper rotation of shape (3, 3)")
    if translation.shape != (2,) or not np.isfinite(translation).all() or not 0 < camera_scale < np.inf:
        raise InputError("a camera needs a positive finite scale and a finite translation of shape (2,)")

    def to_picture(points):
        return camera_scale * np.asarray(points, float) @ rotation.T + [*translation, 0]

    balls = [(to_picture(centre), camera_scale * radius) for centre, radius in eyeballs]
    picture = shade(
        to_picture(vertices), faces, image.shape[1], image.shape[0], colour=colour, eyeballs=balls, gaze=rotation[:, 2]
    )
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
