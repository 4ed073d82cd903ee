import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from caricli.geometry.lines.slide_points import line_shares, slide_points

ARC = np.stack([np.cos(np.linspace(0, 2, 9) ** 1.2), np.sin(np.linspace(0, 2, 9) ** 1.2)], 1)


def test_points_stand_on_the_line_where_they_are_sent():
    shares = np.array([0, 0.3, 0.5, 1])
    moved = slide_points(ARC, shares)
    assert np.abs(np.linalg.norm(moved, axis=1) - 1).max() < 0.01
    angles = np.arctan2(moved[:, 1], moved[:, 0])
    assert np.abs(angles / angles[-1] - shares).max() < 0.01
    np.testing.assert_allclose(moved[[0, -1]], ARC[[0, -1]], atol=1e-12)


def test_points_that_stay_where_they_are_stay_there():
    np.testing.assert_allclose(slide_points(ARC, line_shares(ARC)), ARC, atol=1e-12)


def test_shares_may_be_of_something_else_than_length():
    own = np.linspace(0, 1, 9) ** 2
    np.testing.assert_allclose(slide_points(ARC, own[[2, 5]], own), ARC[[2, 5]], atol=1e-12)


def test_a_point_is_a_line_too():
    same = np.ones((4, 2))
    np.testing.assert_array_equal(slide_points(same, np.array([0, 0.2, 0.9, 1])), same)


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_lines_are_those_of_scipy(count):
    generator = np.random.default_rng(count)
    for _ in range(50):
        line = generator.integers(-3, 4, (count, 2)).astype(float)
        own = np.cumsum(generator.random(count))
        shares = np.concatenate([own, generator.uniform(own[0], own[-1], 20)])
        np.testing.assert_allclose(slide_points(line, shares, own), PchipInterpolator(own, line)(shares), atol=1e-12)
