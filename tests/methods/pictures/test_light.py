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


def test_lamps_of_any_sharpness_send_as_much_light():
    for way in ([0.0, 0, -1], [0.6, -0.8, 0]):
        for sharpness in (1.0, 4.0, 12.0):
            lamp = Sky(np.array([way]), np.ones((1, 3)), np.array([sharpness]), np.zeros(3), np.zeros(3))
            directions = np.random.default_rng(0).normal(size=(40000, 3))
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            np.testing.assert_allclose(lamp.radiance(directions).mean(0), 0.25, rtol=0.1)
            assert (lamp.radiance(np.array([way])) == (sharpness + 1) / 2).all()


def test_the_sky_is_above_and_the_ground_below():
    sky = Sky(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.full(3, 0.9), np.full(3, 0.1))
    np.testing.assert_allclose(sky.radiance(np.array([[0.0, -1, 0], [0, 1, 0], [1, 0, 0]]))[:, 0], [0.9, 0.1, 0.5])


def test_a_lamp_is_mirrored_into_the_camera_half_way():
    for seed in range(10):
        sky = random_sky(np.random.default_rng(seed))
        way = sky.ways[0]
        mirrored = 2 * (way @ sky.half) * sky.half - way
        np.testing.assert_allclose(mirrored, [0, 0, -1], atol=1e-9)


def test_most_light_comes_from_above_and_before_the_face():
    skies = [random_sky(np.random.default_rng(seed)) for seed in range(200)]
    assert np.median([sky.ways[0, 1] for sky in skies]) < -0.2 and all(sky.ways[0, 2] < 0 for sky in skies)
    assert all(sky.ways[1, 2] <= 0 <= sky.ways[2, 2] for sky in skies)
