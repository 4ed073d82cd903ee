"""A part of a face made larger or smaller than the rest, as caricaturists do it."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.smooth_step import smooth_step

REACH = 2.5
"""Distance, in sizes of the part, from which on nothing is moved."""

LEAST = 0.56
"""Factor, above which nothing folds."""

_ROUNDS = 4
_SHARES = np.linspace(0, 1, 17)
"""How often and at which shares of what is left a distance is looked for."""


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
        weight = _weight(np.linalg.norm(apart / self.radii, axis=-1))
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
        """(N, 2) outside the ellipse whose sources are (N, 2).

        At a distance r, sources tell which p that were; the r that p then has is larger than r up to the true one, and
        smaller beyond. It is looked for between both, by the share of the way from 1 to REACH that its logarithm is.
        """
        apart = goal - self.centre
        change = 1 / self.factors - 1
        low = np.zeros(len(goal))
        width = 1.0
        for _ in range(_ROUNDS):
            far = low[:, None] + width * _SHARES
            places = apart[:, None] / (1 + _following(far)[..., None] * change)
            gap = np.log(np.linalg.norm(places / self.radii, axis=-1)) / np.log(REACH) - far
            before = (gap[:, 1:] > 0).sum(1).clip(max=len(_SHARES) - 2)[:, None]
            low = np.take_along_axis(far, before, 1)[:, 0]
            width /= len(_SHARES) - 1
        ends = [np.take_along_axis(gap, before + end, 1)[:, 0] for end in (0, 1)]
        far = (low + width * ends[0] / (ends[0] - ends[1])).clip(0, 1)
        return self.centre + apart / (1 + _following(far)[:, None] * change)


def _following(far: np.ndarray) -> np.ndarray:
    """How far what is at a distance follows, from 1 to 0. far: its logarithm as a share of REACH's."""
    return 1 - smooth_step(far, 0, 1)


def _weight(distance: np.ndarray) -> np.ndarray:
    """How far what is at a distance follows, from 1 to 0."""
    return _following(np.clip(np.log(np.maximum(distance, 1.0)) / np.log(REACH), 0, 1))
