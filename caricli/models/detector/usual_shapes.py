"""How far the shape of a face is from usual ones."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.structures.checks import number_problem, refuse

_LEAST = 1e-9
"""Standard deviation of numbers that do not differ."""


@dataclass(frozen=True, eq=False)
class UsualShapes:
    """Probabilistic principal components of the shapes of usual faces (Tipping and Bishop 1999).

    middle: (N,) the mean shape. axes: (K, N) orthonormal, K below N. spreads: (K + 1,) standard deviations along them,
    and of each of the numbers that they leave.
    """

    middle: np.ndarray
    axes: np.ndarray
    spreads: np.ndarray

    def __post_init__(self) -> None:
        """Raises InputError for numbers that are none, other shapes, or deviations that are not above zero."""
        for name in ("middle", "axes", "spreads"):
            refuse(number_problem(f"usual shapes' {name}", getattr(self, name)))
        shapes = [self.middle.shape, self.axes.shape, self.spreads.shape]
        count = len(self.axes)
        length = self.axes.shape[-1]
        if shapes != [(length,), (count, length), (count + 1,)] or count >= length:
            raise InputError(f"expected middle, axes and spreads of usual shapes that fit each other, found {shapes}")
        if not (self.spreads > 0).all():
            raise InputError("expected spreads of usual shapes above zero, found others")

    @classmethod
    def of(cls, shapes: np.ndarray, count: int) -> "UsualShapes":
        """Of shapes (M, N), with ``count`` axes, or fewer where there are no more shapes."""
        middle = shapes.mean(0)
        _, lengths, axes = np.linalg.svd(shapes - middle, full_matrices=False)
        count = min(count, max(len(axes) - 1, 1))
        along, rest = np.split(lengths**2 / len(shapes), [count])
        variances = np.append(along, rest.sum() / (len(middle) - count))
        return cls(middle, axes[:count], np.maximum(np.sqrt(variances), _LEAST))

    def distances(self, shapes: np.ndarray) -> np.ndarray:
        """(M,) squared distances of shapes (M, N), 1 in the mean of those that they were found in; what is along the
        axes and what these leave count half each."""
        away = shapes - self.middle
        along = away @ self.axes.T
        left = (away**2).sum(1) - (along**2).sum(1)
        count, length = self.axes.shape
        own: np.ndarray = ((along / self.spreads[:-1]) ** 2).mean(1) + left / ((length - count) * self.spreads[-1] ** 2)
        return own / 2
