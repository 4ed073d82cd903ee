import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.models.principal_components import principal_components

ROWS = np.random.default_rng(0).normal(size=(60, 4)) @ np.random.default_rng(1).normal(size=(4, 30)) + 5.0


def test_components_are_directions_of_one_standard_deviation():
    mean, components, explained = principal_components(ROWS, 4)
    assert np.allclose(mean, ROWS.mean(0))
    assert np.allclose(components.T @ components, np.cov(ROWS.T), atol=1e-8)
    products = components @ components.T
    assert np.allclose(products, np.diag(np.diag(products)), atol=1e-8)
    assert explained.sum() == pytest.approx(1.0)
    assert (np.diff(explained) <= 0).all()


def test_fewer_dimensions_are_the_first_ones():
    _, all_components, all_explained = principal_components(ROWS, 4)
    _, components, explained = principal_components(ROWS, 2)
    assert np.allclose(np.abs(components), np.abs(all_components[:2]), atol=1e-6)
    assert np.allclose(explained, all_explained[:2])


def test_never_more_than_the_rows_allow():
    assert len(principal_components(ROWS[:3], 10)[1]) == 2
    assert len(principal_components(ROWS[:, :3], 10)[1]) == 3


def test_repeated_rows_add_no_components():
    mean, components, explained = principal_components(np.concatenate([ROWS[:4], ROWS[:2]]), 10)
    assert len(components) == len(explained) == 3
    assert np.linalg.norm(components, axis=1).min() > 0.1


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 5])
def test_rows_that_are_all_the_same_are_refused(count, dtype):
    with pytest.raises(NumericsError, match=f"at least two shapes that differ, found {count}"):
        principal_components(np.repeat(ROWS[:1], count, axis=0).astype(dtype), 3)


def test_the_same_seed_gives_the_same_bytes():
    rows = np.random.default_rng(2).normal(size=(50, 40))
    assert np.array_equal(principal_components(rows, 5, seed=3)[1], principal_components(rows, 5, seed=3)[1])
