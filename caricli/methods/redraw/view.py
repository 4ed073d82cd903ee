"""A head as a camera sees it, sample by sample."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import scipy.sparse as sp

from caricli.render.visibility.corner_mix import corner_mix
from caricli.render.visibility.nearest_pixel import nearest_pixel
from caricli.render.visibility.rasterise import rasterise

_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


@dataclass(frozen=True, eq=False)
class Window:
    """A part of a picture and the samples in it.

    left, top: pixels of its corner. width, height: pixels. fine: samples along a pixel.
    """

    left: int
    top: int
    width: int
    height: int
    fine: int

    @property
    def size(self) -> tuple[int, int]:
        """Samples, (W, H)."""
        return self.fine * self.width, self.fine * self.height

    @cached_property
    def places(self) -> np.ndarray:
        """(H, W, 2) float32: pixels of the picture at which the samples are."""
        columns, rows = (np.arange(n, dtype=np.float32) for n in self.size)
        grid = np.stack(np.broadcast_arrays(columns, rows[:, None]), axis=2)
        return (grid + 0.5) / self.fine - 0.5 + np.array([self.left, self.top], np.float32)

    def samples(self, placed: np.ndarray) -> np.ndarray:
        """Pixels and depth (V, 3) of the picture as samples and depth in pixels."""
        return np.column_stack([(placed[:, :2] - [self.left, self.top] + 0.5) * self.fine - 0.5, placed[:, 2]])

    def cut(self, picture: np.ndarray) -> np.ndarray:
        """The part of a picture (H, W, ...)."""
        return picture[self.top : self.top + self.height, self.left : self.left + self.width]

    def sampled(self, picture: np.ndarray) -> np.ndarray:
        """The part of a picture (H, W, ...) at its samples, nearest pixels."""
        return self.cut(picture).repeat(self.fine, axis=0).repeat(self.fine, axis=1)

    def means(self, samples: np.ndarray) -> np.ndarray:
        """(height, width, ...) means of the samples (H, W, ...), floats, of every pixel."""
        return cv2.resize(samples, (self.width, self.height), interpolation=cv2.INTER_AREA)


class View:
    """A head in a window, and its outlines: where what is nearer ends before what is farther off.

    placed: (V, 3) pixels and depth. face, weights, depth: of `rasterise`, by sample. covered, inside: (H, W) bool,
    samples that show the head, and those that show what is in its mouth.
    """

    def __init__(self, placed: np.ndarray, faces: np.ndarray, window: Window, jump: float, within: np.ndarray) -> None:
        """placed: (V, 3) pixels and depth of the picture. jump: pixels of depth that make an outline. within: (V,) from
        0 to 1, how far vertices are in the mouth, where no outlines are.
        """
        self.placed = placed
        self.faces = faces
        self.window = window
        self.jump = jump
        raster = rasterise(window.samples(placed), faces, *window.size)
        self.face = raster.face
        self.weights = raster.barycentric
        self.depth = raster.depth
        self.covered = raster.face >= 0
        self.inside = self.carried(within[:, None])[..., 0] > 0.5

    def carried(self, values: np.ndarray) -> np.ndarray:
        """(H, W, C) float32: values (V, C) of vertices at the samples; zeros beside the head."""
        carried = np.zeros((self.face.size, values.shape[1]), np.float32)
        carried[self._spots] = self._mix @ values.astype(np.float32)
        return carried.reshape(*self.face.shape, -1)

    @cached_property
    def _spots(self) -> np.ndarray:
        """(N,) int: the samples that show the head, row by row."""
        return np.flatnonzero(self.covered)

    @cached_property
    def _mix(self) -> sp.csr_matrix:
        """(N, V) float32, sparse: how vertices mix at the samples that show the head."""
        return corner_mix(self.faces[self.face[self.covered]], self.weights[self.covered], len(self.placed))

    @cached_property
    def inwards(self) -> np.ndarray:
        """(H, W) float32 samples from the border of the head, zeros beside it."""
        return cv2.distanceTransform(self.covered.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)

    @cached_property
    def outline(self) -> tuple[np.ndarray, np.ndarray]:
        """Row and column (H, W) of the sample of an outline that is nearest to each."""
        farthest = cv2.dilate(np.where(self.covered, self.depth, np.float32(1e9)), _CROSS)
        contour = self.covered & ~self.inside & (farthest > self.depth + self.jump)
        contour &= cv2.dilate(self.inside.astype(np.uint8), _CROSS) == 0
        return nearest_pixel(contour if contour.any() else ~self.covered)

    @cached_property
    def away(self) -> np.ndarray:
        """(H, W) float32 pixels from the nearest outline, infinite where a sample is not behind what it ends."""
        row, column = self.outline
        rows, columns = np.indices(row.shape)
        away = np.hypot(row - rows, column - columns).astype(np.float32) / self.window.fine
        behind = (self.depth > self.depth[row, column] + self.jump) & ~self.inside
        return np.where(behind, away, np.float32(np.inf))
