"""Where places of a picture are in a part of it that is made larger or smaller."""

import numpy as np


def zoomed_pixels(
    pixels: np.ndarray, zoom: float | np.ndarray, corner: np.ndarray | tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Places (..., 2) in the picture that begins at the left and upper border of the pixel ``corner`` and is ``zoom``
    times as large.

    pixels: (..., 2); the middle of the first pixel is (0, 0) in both pictures, so that their borders, half a pixel
    before it, are the same. zoom: of both, or (2,) across and down.
    """
    return (np.asarray(pixels) - corner + 0.5) * zoom - 0.5
