import numpy as np
import pytest

from caricli.methods.pictures.light import Sky, random_sky
from caricli.methods.texture.estimate_light import harmonics
from caricli.render.sky import DIRECTIONS


@pytest.fixture
def even():
    return Sky(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.full(3, 0.7), np.full(3, 0.7))


def test_light_from_everywhere_alike_has_one_harmonic(even):
    coefficients = even.harmonics(DIRECTIONS)
    np.testing.assert_allclose(coefficients[0], 0.7 * np.sqrt(4 * np.pi), rtol=1e-6)
    assert abs(coefficients[1:]).max() < 0.03


def test_harmonics_follow_the_light_that_they_stand_for():
    lights = [random_sky(np.random.default_rng(seed)) for seed in range(20)]
    for sky in lights:
        radiance = sky.radiance(DIRECTIONS)
        assert (radiance >= 0).all()
        told = harmonics(DIRECTIONS) @ sky.harmonics(DIRECTIONS)
        # Nine harmonics know from where most of it comes.
        brightest = DIRECTIONS[radiance.sum(1).argmax()]
        assert DIRECTIONS[told.sum(1).argmax()] @ brightest > 0.6
