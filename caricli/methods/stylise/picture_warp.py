"""A picture displaced smoothly, and the way of points in it."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.cubic_spline import CubicSpline

_ROUNDS = 400
_STEP = 0.4  # of the way to a point: where areas stay above zero, and below five times their own, steps come nearer
_NEAR = 1e-4  # pixels


@dataclass(frozen=True, eq=False)
class PictureWarp:
    """Where the pixels of a new picture come from, in a window that is mapped onto itself; the rest stays.

    corner: (2,) int, x and y of the window's first pixel. moves: (h, w, 2) pixels, to be added to a pixel of the new
    picture to come to that of the old one.
    """

    corner: np.ndarray
    moves: np.ndarray

    @classmethod
    def of_grid(cls, corner: np.ndarray, moves: np.ndarray, size: tuple[int, int]) -> "PictureWarp":
        """Between the nodes of a grid by cubic splines. moves: (R, C, 2) pixels. size: (w, h) that the grid spans."""
        fine = moves
        for axis, count in enumerate(size[::-1]):
            knots = np.arange(moves.shape[axis], dtype=float)
            fine = CubicSpline(knots, fine.swapaxes(0, axis))(np.linspace(0, knots[-1], count)).swapaxes(0, axis)
        return cls(corner, fine)

    def picture(self, image: np.ndarray) -> np.ndarray:
        """The new picture of one (H, W, 3) uint8."""
        import cv2

        height, width = self.moves.shape[:2]
        x, y = self.corner
        window = (slice(y, y + height), slice(x, x + width))
        rows, columns = np.mgrid[:height, :width]
        across, down = (self.moves + np.stack([columns, rows], -1)).astype(np.float32).transpose(2, 0, 1)
        warped = image.copy()
        warped[window] = cv2.remap(image[window], across, down, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return warped

    def points(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) of the old picture are in the new one; NaN stays NaN.

        The point x of the new picture with ``x + moves(x) = p`` is found in small steps towards it.
        """
        places = np.array(points, np.float64)
        for _ in range(_ROUNDS):
            miss = points - places - self._at(places)
            places += _STEP * miss
            if not np.nanmax(np.abs(miss), initial=0) > _NEAR:
                break
        return places

    def _at(self, places: np.ndarray) -> np.ndarray:
        """Moves (N, 2) at places (N, 2), bilinear; outside of the window those of its border."""
        last = np.array(self.moves.shape[1::-1]) - 1
        inside = np.clip(np.nan_to_num(places - self.corner), 0, last)
        first = np.minimum(np.floor(inside).astype(int), last - 1)
        across, down = (inside - first).T[..., None]
        x, y = first.T
        upper = (1 - across) * self.moves[y, x] + across * self.moves[y, x + 1]
        lower = (1 - across) * self.moves[y + 1, x] + across * self.moves[y + 1, x + 1]
        return (1 - down) * upper + down * lower
