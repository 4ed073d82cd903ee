import numpy as np
import pytest

from caricli.models.linear_basis import LinearBasis, direction_products

ROWS = np.random.default_rng(0).normal(size=(4, 30))


def test_products_are_those_of_the_directions():
    weights = np.random.default_rng(1).uniform(size=30)
    for k in range(4):
        for m in range(4):
            assert direction_products(ROWS)[k, m] == pytest.approx(ROWS[k] @ ROWS[m])
            assert direction_products(ROWS, weights * ROWS)[k, m] == pytest.approx((weights * ROWS[k]) @ ROWS[m])
            assert direction_products(ROWS, ridge=0.5)[k, m] == pytest.approx(ROWS[k] @ ROWS[m] + 0.5 * (k == m))


def test_directions_of_very_different_lengths_are_independent():
    direction_products(ROWS * np.array([1, 1e-2, 1e-4, 1e-5])[:, None])


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-9])
def test_directions_that_are_not_independent_are_refused(apart):
    rows = ROWS.copy()
    rows[3] = rows[0] - 2 * rows[1] + apart * rows[3]
    with pytest.raises(ValueError, match="4 directions that are not independent"):
        direction_products(rows)
    with pytest.raises(ValueError, match="no directions"):
        direction_products(rows[:0])


def test_values_are_the_mean_and_so_much_of_every_direction():
    basis = ROWS.reshape(4, 10, 3)
    mean = np.ones((10, 3))
    found = LinearBasis(mean, basis).combine(np.array([[[1.0, 0, 0, 0], [0, 0, 2, -1]]]))
    np.testing.assert_allclose(found, [[mean + basis[0], mean + 2 * basis[2] - basis[3]]])
