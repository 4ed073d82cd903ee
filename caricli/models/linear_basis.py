"""A mean and the directions in which it varies."""

from dataclasses import dataclass

import numpy as np

_DEPENDENT = 1e-7
"""Of the largest length: a direction that leaves less beside those before it adds nothing to them but rounding."""


def direction_products(rows: np.ndarray, weighted: np.ndarray | None = None, ridge: float = 0.0) -> np.ndarray:
    """The products (D, D) of directions with each other, which solves need to be independent.

    rows: (D, M) directions. weighted: the same with weights of the columns. ridge: added to the squares.
    Raises ValueError when there are none, or they are not independent.
    """
    if not len(rows):
        raise ValueError("no directions in which shapes vary")
    products = (rows if weighted is None else weighted) @ rows.T + ridge * np.eye(len(rows))
    try:
        lengths = np.diag(np.linalg.cholesky(products))
    except np.linalg.LinAlgError:
        lengths = np.zeros(1)
    if not lengths.min() > _DEPENDENT * lengths.max():
        raise ValueError(f"{len(rows)} directions that are not independent")
    return products


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
