"""A picture displaced smoothly, and the way of points in it."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.cubic_spline import CubicSpline

_ROUNDS = 400
_STEP = 0.4  # of the way to a point: where areas stay above zero, and below five times their own, steps come nearer
_NEAR = 1e-4  # pixels


_FINEST = 2048
"""Places of the displacement in each direction, at most; where pixels are more it goes straight between."""

_BAND = 512
"""Rows of pixels that are displaced at once."""


@dataclass(frozen=True, eq=False)
class PictureWarp:
    """Where the pixels of a new picture come from, in a window that is mapped onto itself; the rest stays.

    corner: (2,) int, x and y of the window's first pixel. size: (w, h) pixels of the window. moves: (R, C, 2) pixels,
    to be added to a place in the new picture to come to that in the old one, at places that lie evenly from the first
    to the last pixel.
    """

    corner: np.ndarray
    size: tuple[int, int]
    moves: np.ndarray

    @classmethod
    def of_grid(cls, corner: np.ndarray, moves: np.ndarray, size: tuple[int, int]) -> "PictureWarp":
        """Between the nodes of a coarse grid by cubic splines. moves: (R, C, 2) pixels. size: (w, h) that it spans."""
        for axis, count in enumerate(size[::-1]):
            knots = np.arange(moves.shape[axis], dtype=float)
            places = np.linspace(0, knots[-1], min(count, _FINEST))
            moves = CubicSpline(knots, moves.swapaxes(0, axis))(places).swapaxes(0, axis)
        return cls(corner, size, moves)

    @property
    def steps(self) -> np.ndarray:
        """(2,) pixels between places, in x and y."""
        return (np.array(self.size) - 1) / (np.array(self.moves.shape[1::-1]) - 1)

    def picture(self, image: np.ndarray) -> np.ndarray:
        """The new picture of one (H, W, 3) uint8."""
        import cv2

        width, height = self.size
        x, y = self.corner
        window = image[y : y + height, x : x + width]
        warped = image.copy()
        for first in range(0, height, _BAND):
            columns, rows = np.meshgrid(np.arange(width), np.arange(first, min(first + _BAND, height)))
            pixels = np.stack([columns, rows], -1)
            across, down = (pixels + self._between(pixels)).astype(np.float32).transpose(2, 0, 1)
            band = cv2.remap(window, across, down, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
            warped[y + first : y + first + len(band), x : x + width] = band
        return warped

    def points(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) of the old picture are in the new one; NaN stays NaN.

        The point x of the new picture with ``x + moves(x) = p`` is found in small steps towards it.
        """
        places = np.array(points, np.float64)
        for _ in range(_ROUNDS):
            inside = np.clip(np.nan_to_num(places - self.corner), 0, np.array(self.size) - 1)
            miss = points - places - self._between(inside)
            places += _STEP * miss
            if not np.nanmax(np.abs(miss), initial=0) > _NEAR:
                break
        return places

    def _between(self, pixels: np.ndarray) -> np.ndarray:
        """Moves (..., 2) at pixels (..., 2) of the window."""
        at = pixels / self.steps
        first = np.minimum(np.floor(at).astype(int), np.array(self.moves.shape[1::-1]) - 2)
        across, down = np.moveaxis(at - first, -1, 0)[..., None]
        x, y = np.moveaxis(first, -1, 0)
        upper = (1 - across) * self.moves[y, x] + across * self.moves[y, x + 1]
        lower = (1 - across) * self.moves[y + 1, x] + across * self.moves[y + 1, x + 1]
        return (1 - down) * upper + down * lower
