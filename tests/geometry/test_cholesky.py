import pickle
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky


def system(size):
    return sp.diags([np.full(size - 1, -1.0), np.full(size, 2.5), np.full(size - 1, -1.0)], [-1, 0, 1])


@pytest.mark.parametrize("columns", [1, 3, 7])
@pytest.mark.parametrize("order", ["C", "F"])
def test_every_column_is_solved(columns, order):
    right = np.asarray(np.random.default_rng(0).normal(size=(40, columns)), order=order)
    given = right.copy()
    found = Cholesky(system(40)).solve(right)
    np.testing.assert_allclose(system(40) @ found, right, atol=1e-12)
    np.testing.assert_array_equal(right, given)
    assert found.flags["F_CONTIGUOUS"] == right.flags["F_CONTIGUOUS"]


def test_no_answer_is_an_error():
    with pytest.raises(NumericsError, match="no finite solution"):
        Cholesky(system(4)).solve(np.full((4, 2), np.nan))


def test_a_matrix_that_is_not_positive_definite_is_refused():
    with pytest.raises(NumericsError, match="a sparse system has no solution"):
        Cholesky(sp.diags([1.0, -1.0, 1.0]))


def test_another_process_gets_one_that_solves_alike():
    right = np.arange(12.0).reshape(6, 2)
    factor = Cholesky(system(6))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(factor)).solve(right), factor.solve(right))


def test_what_is_kept_until_the_end_is_no_leak():
    """As a thread that still waits keeps it."""
    script = (
        "import threading, time, scipy.sparse as sp; from caricli.geometry.cholesky import Cholesky; "
        "factor = Cholesky(sp.identity(3)); "
        "threading.Thread(target=lambda: (time.sleep(60), factor), daemon=True).start()"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ended.stderr == ""
