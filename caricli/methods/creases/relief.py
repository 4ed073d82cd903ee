"""Folds as heights over the usual face seen from the front, which every face of a topology shares."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.creases.crease_pattern import Crease, CreasePattern
from caricli.render.pixels.sample_texture import sample_pixels

_STEP = 0.006  # widths of the face, between points of the grid
_LOW = (-0.95, -1.5)
_HIGH = (0.95, 0.9)
_REACH = 5.0  # widths of a crease, how far it changes the skin


@dataclass(frozen=True, eq=False)
class Relief:
    """Skin over the usual face: slopes (H, W, 2), of heights over distances across and up; stain (H, W), how much
    darker, of logarithms."""

    slopes: np.ndarray
    stain: np.ndarray

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Slopes (N, 2) and stains (N,) at places (N, 2), widths of the face; zero beyond."""
        column, row = ((places - _LOW) / _STEP).astype(np.float32).T
        values = np.dstack([self.slopes, self.stain])
        seen = sample_pixels(values, column, row, border=0.0)
        return seen[:, :2], seen[:, 2]


class ReliefMaker:
    """The folds of one person, prepared for many expressions."""

    def __init__(self, pattern: CreasePattern) -> None:
        """pattern: CreasePattern."""
        self.size = tuple(np.round((np.array(_HIGH) - _LOW) / _STEP).astype(int)[::-1])
        self.stamps = [_Stamp(crease, self.size) for crease in pattern.creases]

    def relief(self, weights: Mapping[str, float]) -> Relief:
        """The Relief of weights of actions."""
        heights = np.zeros(self.size, np.float32)
        stain = np.zeros(self.size, np.float32)
        for stamp in self.stamps:
            stamp.press(heights, stain, weights)
        up, across = np.gradient(heights, _STEP)
        return Relief(np.dstack([across, up]).astype(np.float32), stain)


class _Stamp:
    """What one crease does to a grid."""

    def __init__(self, crease: Crease, size: tuple[int, ...]) -> None:
        self.crease = crease
        reach = _REACH * crease.width
        limits = [(crease.path.min(0) - reach - _LOW) / _STEP, (crease.path.max(0) + reach - _LOW) / _STEP]
        low, high = np.clip(np.array(limits).astype(int), 0, np.array(size)[::-1])
        self.window = np.s_[low[1] : high[1], low[0] : high[0]]
        rows, columns = np.mgrid[self.window]
        places = np.stack([columns, rows], -1) * _STEP + _LOW
        distance, self.nearest = KDTree(crease.path).query(places)
        along = np.gradient(crease.path, axis=0)
        away = places - crease.path[self.nearest]
        tangent = along[self.nearest]
        left = np.sign(tangent[..., 0] * away[..., 1] - tangent[..., 1] * away[..., 0])
        u = distance / crease.width
        self.groove = np.exp(-(u**2)).astype(np.float32)
        rim = 0.3 * np.exp(-(((u - 2) / 0.9) ** 2))
        side = left * np.sign(crease.bulge)
        fold = abs(crease.bulge) * np.exp(-(((u - 2) / 1.4) ** 2)) * (side > 0) * np.clip(u, 0, 1)
        self.shape = (rim + fold - self.groove).astype(np.float32)

    def press(self, heights: np.ndarray, stain: np.ndarray, weights: Mapping[str, float]) -> None:
        """Add it to heights and stains (H, W), as far as weights draw it."""
        strength = self.crease.strength(weights)
        if strength.max() <= 0:
            return
        drawn = strength[self.nearest].astype(np.float32)
        heights[self.window] += self.crease.depth * drawn * self.shape
        stain[self.window] += self.crease.stain * drawn * self.groove
