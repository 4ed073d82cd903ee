import numpy as np

from caricli.render.pixels.levels import saturated, to_bytes, to_floats


def test_bytes_come_back_and_what_is_beyond_is_cut_off():
    levels = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(to_bytes(to_floats(levels)), levels)
    np.testing.assert_array_equal(to_bytes(np.array([-1.0, 0.4999 / 255, 0.5001 / 255, 2.0])), [0, 0, 1, 255])


def test_colours_go_away_from_grey_and_greys_stay():
    image = np.random.default_rng(0).uniform(0.3, 0.7, (4, 5, 3))
    np.testing.assert_allclose(saturated(image, 1), image)
    grey = image.mean(2, keepdims=True)
    np.testing.assert_allclose(saturated(image, 1.2) - grey, 1.2 * (image - grey))
    np.testing.assert_allclose(saturated(np.broadcast_to(grey, image.shape), 3), np.broadcast_to(grey, image.shape))
    assert saturated(image, 50).min() == 0 and saturated(image, 50).max() == 1
