import numpy as np
import pytest

from caricli.methods.train.detector.scale_part import LEAST, REACH, PartScale

CENTRE = np.array([0.2, -0.1])
RADII = np.array([0.3, 0.15])
FACTORS = [(1.9, 1.9), (0.6, 1.9), (1.9, 0.6), (LEAST, LEAST), (6.0, LEAST), (1.0, 1.0)]


def plane(step):
    ends = np.arange(-1.5, 1.5, step)
    return np.stack(np.meshgrid(ends, ends), -1)


@pytest.mark.parametrize("factors", FACTORS)
def test_there_and_back(factors):
    scale = PartScale(CENTRE, RADII, np.array(factors))
    points = plane(0.03)
    np.testing.assert_allclose(scale.sources(scale.places(points)), points, atol=1e-8)
    np.testing.assert_allclose(scale.places(scale.sources(points)), points, atol=1e-5)


@pytest.mark.parametrize("factors", FACTORS)
def test_nothing_folds(factors):
    sources = PartScale(CENTRE, RADII, np.array(factors)).sources(plane(0.003))
    across = np.diff(sources, axis=1)[:-1]
    down = np.diff(sources, axis=0)[:, :-1]
    assert (across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0] > 0).all()


def test_below_the_least_factor_it_would_fold():
    sources = PartScale(CENTRE, RADII, np.full(2, LEAST - 0.03)).sources(plane(0.003))
    across = np.diff(sources, axis=1)[:-1]
    down = np.diff(sources, axis=0)[:, :-1]
    assert (across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0] < 0).any()


def test_an_ellipse_is_scaled_and_what_is_far_stays():
    factors = np.array([1.5, 0.8])
    scale = PartScale(CENTRE, RADII, factors)
    angles = np.linspace(0, 2 * np.pi, 40)[:, None]
    circle = np.hstack([np.cos(angles), np.sin(angles)])
    inside = CENTRE + 0.99 * circle * RADII / factors
    np.testing.assert_allclose(scale.places(inside), CENTRE + factors * (inside - CENTRE), atol=1e-9)
    outside = CENTRE + 1.001 * REACH * circle * RADII
    np.testing.assert_array_equal(scale.places(outside), outside)
    np.testing.assert_array_equal(scale.sources(outside), outside)
