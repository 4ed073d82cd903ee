"""Label maps no larger than what is done with them needs."""

import numpy as np

from caricli.structures import Camera


def smaller_labels(
    regions: np.ndarray, camera: Camera, vertices: np.ndarray, height: float
) -> tuple[np.ndarray, Camera]:
    """A label map (H, W) and its Camera, made smaller where a head (V, 3) is higher in it than so many pixels.

    Its pixels have the labels at their middles; what its whole sides leave over is the same at both ends.
    """
    zoom = min(height / max(np.ptp(camera.project(vertices)[:, 1]), 1.0), 1.0)
    if zoom == 1:
        return regions, camera
    sides = np.array(regions.shape[::-1])
    size = np.maximum(np.round(zoom * sides), 1).astype(int)
    corner = (sides - size / zoom) / 2
    columns, rows = (
        np.clip(np.round((np.arange(count) + 0.5) / zoom - 0.5 + start), 0, side - 1).astype(int)
        for count, start, side in zip(size, corner, sides, strict=True)
    )
    return regions[np.ix_(rows, columns)], camera.zoomed(zoom, corner)
