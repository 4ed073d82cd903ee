import numpy as np
import pytest
from scipy.interpolate import CubicSpline as Reference

from caricli.geometry.lines.cubic_spline import CubicSpline


@pytest.mark.parametrize("count", [4, 5, 17])
def test_it_is_the_spline_that_scipy_has(count):
    generator = np.random.default_rng(count)
    knots = np.cumsum(generator.uniform(0.2, 1.0, count))
    values = generator.normal(size=(count, 2, 3))
    places = generator.uniform(knots[0], knots[-1], (6, 7))
    expected = Reference(knots, values)(places)
    np.testing.assert_allclose(CubicSpline(knots, values)(places), expected, rtol=1e-9, atol=1e-12)


def test_it_goes_through_its_points():
    knots = np.array([0.0, 0.3, 0.4, 1.0])
    values = np.array([1.0, -1.0, 2.0, 0.0])
    np.testing.assert_allclose(CubicSpline(knots, values)(knots), values, atol=1e-12)
