"""A sparse matrix on arrays with leading dimensions."""

from math import prod

import numpy as np
import scipy.sparse as sp


def per_column(matrix: sp.spmatrix, values: np.ndarray) -> np.ndarray:
    """Multiply along the last dimension but one.

    matrix: (M, N) sparse. values: (..., N, n).
    Returns (..., M, n).
    """
    columns = np.moveaxis(values, -2, 0)
    product = matrix @ columns.reshape(len(columns), prod(columns.shape[1:]))
    return np.moveaxis(product.reshape(len(product), *columns.shape[1:]), 0, -2)
