"""What painters are given."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from caricli.geometry.smooth_step import smooth_step

_LIGHT = np.array([0.299, 0.587, 0.114], np.float32)


@dataclass(frozen=True, eq=False)
class Canvas:
    """A picture to be painted, and how large the face in it is.

    image: (H, W, 3) float32 sRGB, 0 to 1. unit: pixels, a hundredth of the diagonal of the face's landmarks, in which
    all that painters do is measured. care: (H, W) float32, 1 on the face, falling to 0 away from it. generator: of
    strokes and grain. guide: (H, W, 3) as the image, the picture that strokes follow, where it is another.
    """

    image: np.ndarray
    unit: float
    care: np.ndarray
    generator: np.random.Generator
    guide: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        height, width = self.care.shape
        return height, width

    @cached_property
    def light(self) -> np.ndarray:
        """(H, W) float32, how light pixels look, 0 to 1."""
        return self.image @ _LIGHT

    @cached_property
    def guiding_light(self) -> np.ndarray:
        """(H, W) float32, the same of what strokes follow."""
        return self.light if self.guide is None else self.guide @ _LIGHT

    def blurred(self, values: np.ndarray, units: float) -> np.ndarray:
        """Values (H, W, ...) blurred by a Gaussian of so many units."""
        import cv2

        return cv2.GaussianBlur(values, (0, 0), max(units * self.unit, 0.3), borderType=cv2.BORDER_REFLECT)

    def noise(self, units: float) -> np.ndarray:
        """(H, W) float32, smooth noise of deviation near 1 with blobs of so many units."""
        import cv2

        height, width = self.shape
        side = max(units * self.unit, 1.0)
        cells = (int(np.ceil(height / side)) + 1, int(np.ceil(width / side)) + 1)
        coarse = self.generator.normal(size=cells).astype(np.float32)
        size = (max(width, round(cells[1] * side)), max(height, round(cells[0] * side)))
        return cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)[:height, :width]


def step(values: np.ndarray, width: float) -> np.ndarray:
    """0 below zero and 1 above, rising smoothly over a width."""
    return smooth_step(values, -width / 2, width / 2)
