import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_landmark_map import landmark_error


def test_errors_are_shares_of_the_diagonal():
    true = np.random.default_rng(0).normal(size=(2, 68, 2))
    diagonals = np.linalg.norm(np.ptp(true, axis=1), axis=1)
    found = true + [0.0, 1.0] * diagonals[:, None, None] / 50
    assert landmark_error(found, true) == pytest.approx(2)
