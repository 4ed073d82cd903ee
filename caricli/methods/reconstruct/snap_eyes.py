"""Eye landmarks on the border of the eyes that a face parser found (portrait paper, section 3.2.1)."""

import cv2
import numpy as np

from caricli.methods.reconstruct.settings import SnapSettings
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT


def snap_eyes(
    points: np.ndarray,
    eyes: np.ndarray | None,
    settings: SnapSettings = SnapSettings(),  # noqa: B008 (frozen)
) -> tuple[np.ndarray, int]:
    """Move every eye landmark to the nearest point on the border of the eyes, where one is near and no other landmark
    of the eye went there.

    points: (L, 2) pixels, NaN where unknown. eyes: (H, W) bool, pixels that show an eye, or None where
    nobody knows. settings: SnapSettings.
    Returns (L, 2), and how many landmarks moved.
    """
    snapped = np.array(points)
    moved = 0
    if eyes is None:
        return snapped, moved
    outlines, _ = cv2.findContours(eyes.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return snapped, moved
    # Contours run through the middles of the outermost pixels.
    border = np.concatenate([outline[:, 0] for outline in outlines]).astype(float)
    for eye in (EYE_RIGHT, EYE_LEFT):
        ids = [k for k in eye if np.isfinite(points[k]).all()]
        if len(ids) < 2:
            continue
        width = np.linalg.norm(np.ptp(points[ids], axis=0))
        for k in ids:
            distances = np.linalg.norm(border - points[k], axis=1)
            place = border[distances.argmin()]
            taken = (snapped[[other for other in ids if other != k]] == place).all(axis=1).any()
            if distances.min() <= settings.farthest * width and not taken:
                snapped[k] = place
                moved += 1
    return snapped, moved
