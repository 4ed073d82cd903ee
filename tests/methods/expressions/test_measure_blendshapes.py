import numpy as np
import pytest

from caricli.methods.expressions.measure_blendshapes import measure_blendshapes


@pytest.fixture
def normal():
    """Two expressions of 100 vertices, of which half keep still, and one that does nothing."""
    moves = np.zeros((3, 100, 3))
    moves[0, :50, 0], moves[1, 30:80, 1] = 0.01, np.linspace(0.006, 0.01, 50)
    return moves


def test_the_same_moves_are_perfect(normal):
    found = measure_blendshapes(normal, normal)
    np.testing.assert_allclose(found.strength[:2], 1)
    np.testing.assert_allclose(found.drift[:2], 0)
    np.testing.assert_allclose(found.excess[:2], 0)
    assert found.structure == pytest.approx(0)
    assert np.isnan([found.strength[2], found.drift[2], found.excess[2]]).all()


def test_what_is_done_to_the_moves_is_measured(normal):
    moves = 1.5 * normal
    moves[0, 50:] = [0, 0, 0.002]
    found = measure_blendshapes(moves, normal)
    np.testing.assert_allclose(found.strength[:2], 1.5)
    np.testing.assert_allclose(found.drift[:2], [0.002, 0])
    np.testing.assert_allclose(found.excess[:2], [0.5 + 0.2, 0.5])
    turned = normal[[0, 0, 2]]
    assert measure_blendshapes(turned, normal).structure == pytest.approx(1)
