"""Sparse symmetric systems with many right-hand sides."""

import numpy as np
from cholespy import CholeskySolverD, MatrixType

from caricli.errors import NumericsError

_BLOCK = 3


class Cholesky:
    """A sparse symmetric positive definite matrix, factored once."""

    def __init__(self, matrix):
        """matrix: (n, n) sparse. Raises NumericsError where it is not positive definite."""
        entries = matrix.tocoo()
        rows, columns = entries.row.astype(np.int32), entries.col.astype(np.int32)
        try:
            self._solver = CholeskySolverD(matrix.shape[0], rows, columns, entries.data, MatrixType.COO)
        except ValueError as error:
            raise NumericsError("a sparse system has no solution: does a part of the mesh hang on nothing?") from error

    def solve(self, right):
        """Solve for every column. right: (n, m). Returns the same shape. Raises NumericsError where there is none."""
        solution = np.empty_like(right)
        # A few columns at a time stay in the cache.
        for start in range(0, right.shape[1], _BLOCK):
            block = np.ascontiguousarray(right[:, start : start + _BLOCK])
            found = np.empty_like(block)
            self._solver.solve(block, found)
            solution[:, start : start + _BLOCK] = found
        if not np.isfinite(solution).all():
            raise NumericsError("a sparse system has no finite solution: are there degenerate triangles?")
        return solution
