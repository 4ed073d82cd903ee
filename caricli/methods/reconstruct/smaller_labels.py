"""Label maps no larger than what is done with them needs."""

import cv2
import numpy as np

from caricli.structures import Camera


def smaller_labels(
    regions: np.ndarray, camera: Camera, vertices: np.ndarray, height: float
) -> tuple[np.ndarray, Camera]:
    """A label map (H, W) and its Camera, made smaller where a head (V, 3) is higher in it than so many pixels."""
    zoom = min(height / max(np.ptp(camera.project(vertices)[:, 1]), 1.0), 1.0)
    if zoom == 1:
        return regions, camera
    size = [max(round(zoom * side), 1) for side in regions.shape[1::-1]]
    return cv2.resize(regions, size, interpolation=cv2.INTER_NEAREST_EXACT), camera.zoomed(zoom)
