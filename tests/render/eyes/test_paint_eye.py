import numpy as np

from caricli.render.eyes.paint_eye import IRIS, PUPIL, paint_eye

SIZE = 128


def radii():
    y, x = (np.mgrid[:SIZE, :SIZE] + 0.5) / SIZE - 0.5
    return np.hypot(x, y), x, y


def test_a_dark_pupil_a_coloured_iris_and_a_light_sclera():
    picture = paint_eye(SIZE, np.random.default_rng(0))
    assert picture.shape == (SIZE, SIZE, 3) and picture.dtype == np.uint8
    radius, x, y = radii()
    # The light lies above and to the left of the middle.
    away = (x > 0) | (y > 0)
    pupil, iris, sclera = (
        picture[where].astype(int)
        for where in (
            (radius < 0.8 * PUPIL) & away,
            (radius > 1.3 * PUPIL) & (radius < 0.8 * IRIS) & away,
            (radius > 1.2 * IRIS) & (radius < 0.12),
        )
    )
    assert pupil.mean() < 20 and 40 < iris.mean() < 160 and sclera.min() > 200
    assert (iris[:, 0] > iris[:, 2]).all()
    assert picture[~away & (radius < IRIS)].min(-1).max() > 230 and picture[radius > 0.4].mean() > 150


def test_the_generator_decides_the_fibres_alone():
    first, again, other = (paint_eye(SIZE, np.random.default_rng(seed)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    differs = (first != other).any(-1)
    radius = radii()[0]
    assert differs.any() and radius[differs].max() < 1.1 * IRIS and radius[differs].min() > 0.8 * PUPIL


def test_given_colours_take_the_place_of_the_usual_ones():
    blue, grey = np.array([70.0, 110.0, 190.0]), np.array([180.0, 180.0, 190.0])
    picture = paint_eye(SIZE, np.random.default_rng(0), blue, grey).astype(float)
    radius, x, y = radii()
    iris = picture[(radius > 1.2 * PUPIL) & (radius < 0.6 * IRIS) & ((x > 0) | (y > 0))].mean(0)
    assert iris[2] > iris[1] > iris[0] and np.abs(iris - blue).max() < 40
    np.testing.assert_allclose(picture[(radius > 1.2 * IRIS) & (radius < 0.1)].mean(0), grey, atol=6)


def test_the_pupil_is_as_much_larger_as_the_iris():
    dark = []
    for reach in (IRIS, 2 * IRIS):
        radius, x, y = radii()
        picture = paint_eye(SIZE, np.random.default_rng(0), reach=reach).max(-1)
        dark.append(radius[(picture < 30) & ((x > 0) | (y > 0))].max())
    assert abs(dark[1] / dark[0] - 2) < 0.2
