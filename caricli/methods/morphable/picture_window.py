"""The part of a picture around landmarks, at the size at which colours are compared."""

import numpy as np

from caricli.render.pixels.cut_window import cut_window
from caricli.structures.zoomed_pixels import zoomed_pixels


class PictureWindow:
    """A window of a picture.

    image: (H, W, 3) sRGB from 0 to 1. sure: (H, W) from 0 to 1, where it shows what is to be compared. zoom: of it.
    """

    def __init__(self, image: np.ndarray, points: np.ndarray, diagonal: float, margin: float) -> None:
        """image: (H, W, 3) uint8. points: (L, 2) pixels that are in it. diagonal: pixels of theirs in the window.

        margin: around them, a share of their diagonal.
        """
        own = float(np.linalg.norm(np.ptp(points, axis=0)))
        self.zoom = diagonal / own
        self.corner = points.min(0) - margin * own
        width, height = np.ceil((np.ptp(points, axis=0) + 2 * margin * own) * self.zoom).astype(int).tolist()
        self._cut = np.column_stack([self.zoom * np.eye(2), self.to_window(np.zeros(2))]), (width, height)
        self.image = cut_window(image, *self._cut) / 255.0
        there = self.to_picture(np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1))
        limits = np.array([image.shape[1], image.shape[0]])
        self.sure = ((there > -0.5) & (there < limits - 0.5)).all(-1).astype(float)

    def trust(self, shown: np.ndarray) -> None:
        """Compare only what a map (H, W) of the picture, from 0 to 1, says is shown."""
        levels = np.repeat(np.round(255 * shown).astype(np.uint8)[..., None], 3, axis=2)
        self.sure = self.sure * cut_window(levels, *self._cut)[..., 0] / 255.0

    def to_window(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the picture to those of the window."""
        return zoomed_pixels(pixels, self.zoom, self.corner)

    def to_picture(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the window to those of the picture."""
        return (pixels + 0.5) / self.zoom + self.corner - 0.5
