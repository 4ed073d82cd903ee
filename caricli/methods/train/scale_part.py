"""A part of a face made larger or smaller than the rest, as caricaturists do it."""

from dataclasses import dataclass

import numpy as np

REACH = 2.5
"""Distance, in sizes of the part, from which on nothing is moved."""

LEAST = 0.56
"""Factor, above which nothing folds."""

_ROUNDS = 30
_CLOSE = 1e-5
"""Gap, in the plane's units, from which one more step, whose gap is about the square of this, is the last."""


@dataclass(frozen=True, eq=False)
class PartScale:
    """A smooth map of the plane without folds, which scales an ellipse and pushes aside or draws near what is around.

    What comes from the source q is afterwards at p, where q - c = (1 + w(r) (1 / factors - 1)) (p - c), for each axis,
    with r the length of (p - c) / radii, and w(r) falling from 1 at r = 1 to 0 at r = REACH. The determinant of its
    derivative has the sign of 1 + (r w)' d for a d between both values of 1 / factors - 1; (r w)' is at least -1.23 and
    at most 1, so that factors above LEAST do not fold.

    centre: (2,) that stays in its place. radii: (2,) half axes of the ellipse that is scaled as a whole, afterwards.
    factors: (2,) across and down.
    """

    centre: np.ndarray
    radii: np.ndarray
    factors: np.ndarray

    def sources(self, points: np.ndarray) -> np.ndarray:
        """Where what is afterwards at points (..., 2) came from."""
        apart = points - self.centre
        weight = _weight(np.linalg.norm(apart / self.radii, axis=-1))[0]
        return self.centre + apart * (1 + weight[..., None] * (1 / self.factors - 1))

    def places(self, points: np.ndarray) -> np.ndarray:
        """Where points (..., 2) are afterwards."""
        flat = points.reshape(-1, 2)
        apart = flat - self.centre
        # Within the ellipse all is scaled alike, which is a good beginning near it, too.
        near = np.linalg.norm(apart * self.factors / self.radii, axis=1, keepdims=True)
        places = np.where(near <= 1, self.centre + apart * self.factors, flat)
        around = (near[:, 0] > 1) & (self.sources(flat) != flat).any(1)
        if around.any():
            places[around] = self._solved(flat[around])
        return places.reshape(points.shape)

    def _solved(self, goal: np.ndarray) -> np.ndarray:
        """(N, 2) whose sources are (N, 2), by Newton's method with steps that are halved until they help."""
        places = goal
        gap = self.sources(places) - goal
        for _ in range(_ROUNDS):
            size = np.abs(gap).max(1)
            step = self._step(places, gap)
            if size.max() < _CLOSE:
                return places - step
            for _ in range(_ROUNDS):
                left = self.sources(places - step) - goal
                worse = np.abs(left).max(1) > size
                if not worse.any():
                    break
                step[worse] /= 2
            places = places - step
            gap = left
        return places

    def _step(self, points: np.ndarray, gap: np.ndarray) -> np.ndarray:
        """(N, 2) what the sources of points (N, 2) must be moved by to change by (N, 2), were they linear.

        Their derivative is a diagonal and a product of two vectors, whose inverse is that of Sherman and Morrison.
        """
        apart = points - self.centre
        distance = np.linalg.norm(apart / self.radii, axis=1)
        weight, slope = _weight(distance)
        change = 1 / self.factors - 1
        growth = (slope / np.maximum(distance, 1.0))[:, None] * apart / self.radii**2
        own = 1 + weight[:, None] * change
        plain = gap / own
        product = apart * change / own
        return plain - product * ((growth * plain).sum(1) / (1 + (growth * product).sum(1)))[:, None]


def _weight(distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far what is at a distance follows, from 1 to 0, and the derivative."""
    far = np.clip(np.log(np.maximum(distance, 1.0)) / np.log(REACH), 0, 1)
    slope = -6 * far * (1 - far) / (np.log(REACH) * np.maximum(distance, 1.0))
    return 1 - far**2 * (3 - 2 * far), slope
