"""A mean and the directions in which it varies."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class LinearBasis:
    """Values at the vertices: ``mean + coefficients @ basis``.

    mean: (V, 3). basis: (D, V, 3), each direction one standard deviation long.
    """

    mean: np.ndarray
    basis: np.ndarray

    def combine(self, coefficients: np.ndarray) -> np.ndarray:
        """Coefficients (..., D) to values (..., V, 3)."""
        return self.mean + np.tensordot(coefficients, self.basis, 1)
