"""Sparse symmetric systems with many right-hand sides."""

import atexit
from weakref import WeakSet

import numpy as np
import scipy.sparse as sp
from cholespy import CholeskySolverD, MatrixType

from caricli.errors import NumericsError

_BLOCK = 3  # columns solved at once: so many stay in the cache

_factored: "WeakSet[Cholesky]" = WeakSet()


class Cholesky:
    """A sparse symmetric positive definite matrix, factored once."""

    def __init__(self, matrix: sp.spmatrix) -> None:
        """matrix: (n, n) sparse. Raises NumericsError where it is not positive definite."""
        self._matrix = matrix
        entries = matrix.tocoo()
        rows = entries.row.astype(np.int32)
        columns = entries.col.astype(np.int32)
        try:
            self._solver = CholeskySolverD(matrix.shape[0], rows, columns, entries.data, MatrixType.COO)
        except ValueError as error:
            raise NumericsError("a sparse system has no solution: does a part of the mesh hang on nothing?") from error
        _factored.add(self)

    def __reduce__(self) -> tuple[type["Cholesky"], tuple[sp.spmatrix]]:
        """Another process factors it again."""
        return Cholesky, (self._matrix,)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for every column.

        right: (n, m).
        Returns the same shape. Raises NumericsError where there is no finite solution.
        """
        solution = np.empty_like(right)
        for start in range(0, right.shape[1], _BLOCK):
            block = np.ascontiguousarray(right[:, start : start + _BLOCK])
            solved = np.empty_like(block)
            self._solver.solve(block, solved)
            solution[:, start : start + _BLOCK] = solved
        if not np.isfinite(solution).all():
            raise NumericsError("a sparse system has no finite solution: are there degenerate triangles?")
        return solution


@atexit.register
def _forget() -> None:
    """Free all factors before Python ends: those that are left then are reported on stderr as leaks."""
    for each in list(_factored):
        del each._solver
