"""Smooth curves through points."""

import numpy as np


class CubicSpline:
    """The cubic spline whose first and last two pieces are one polynomial each ("not a knot"), in any number of values.

    SciPy has it, too, in a package whose import takes 0.3 s of every command that attaches teeth.
    """

    def __init__(self, knots: np.ndarray, values: np.ndarray) -> None:
        """knots: (N,), ascending, at least 4. values: (N, ...) there."""
        self.knots = knots
        self.values = values
        step = np.diff(knots)
        rise = np.diff(values.reshape(len(knots), -1), axis=0) / step[:, None]
        before, after = step[:-1, None], step[1:, None]
        matrix = np.diag(np.concatenate([step[1:2], 2 * (step[:-1] + step[1:]), step[-2:-1]]))
        matrix += np.diag(np.concatenate([[knots[2] - knots[0]], step[:-1]]), 1)
        matrix += np.diag(np.concatenate([step[1:], [knots[-1] - knots[-3]]]), -1)
        first = _end(step[0], step[1], rise[0], rise[1])
        last = _end(step[-1], step[-2], rise[-1], rise[-2])
        inner = 3 * (after * rise[:-1] + before * rise[1:])
        self.slopes = np.linalg.solve(matrix, np.vstack([first, inner, last])).reshape(values.shape)

    def __call__(self, places: np.ndarray) -> np.ndarray:
        """(*P, ...) values at places (*P)."""
        piece = np.clip(np.searchsorted(self.knots, places, "right") - 1, 0, len(self.knots) - 2)
        step = (self.knots[piece + 1] - self.knots[piece]).reshape(*piece.shape, *[1] * (self.values.ndim - 1))
        t = (places - self.knots[piece]).reshape(step.shape) / step
        start, end = self.values[piece], self.values[piece + 1]
        away, back = step * self.slopes[piece], step * self.slopes[piece + 1]
        return start + t * (away + t * (3 * (end - start) - 2 * away - back + t * (2 * (start - end) + away + back)))


def _end(outer: float, inner: float, outer_rise: np.ndarray, inner_rise: np.ndarray) -> np.ndarray:
    """What the equation of the slope at an end is equal to, by the two steps there and how values rise over them."""
    both = outer + inner
    return ((outer + 2 * both) * inner * outer_rise + outer**2 * inner_rise) / both
