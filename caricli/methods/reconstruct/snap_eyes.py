"""Eye landmarks on the border of the eyes that a face parser found (portrait paper, section 3.2.1)."""

import cv2
import numpy as np

EYES = range(36, 42), range(42, 48)
FARTHEST = 0.5


def snap_eyes(points, parsing, labels):
    """Move every eye landmark to the nearest point on the border of a label, where one is near.

    points: (L, 2) pixels, NaN where unknown. parsing: (H, W) int, a label for every pixel. labels: numbers of the eyes.
    No landmark goes further than ``FARTHEST`` of its eye's width.
    Returns (L, 2), and how many landmarks moved.
    """
    snapped, moved = np.array(points), 0
    outlines, _ = cv2.findContours(np.isin(parsing, labels).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return snapped, 0
    # Contours run through the middles of the outermost pixels.
    border = np.concatenate([outline[:, 0] for outline in outlines]).astype(float)
    for eye in EYES:
        known = [k for k in eye if np.isfinite(points[k]).all()]
        if len(known) < 2:
            continue
        width = np.linalg.norm(np.ptp(points[known], axis=0))
        for k in known:
            distances = np.linalg.norm(border - points[k], axis=1)
            if distances.min() <= FARTHEST * width:
                snapped[k], moved = border[distances.argmin()], moved + 1
    return snapped, moved
