import numpy as np

from caricli.render.pixels.smaller_mask import smaller_mask


def test_pixels_have_what_more_than_half_of_them_has():
    generator = np.random.default_rng(0)
    mask = generator.random((24, 40)) < 0.5
    shares = mask.reshape(6, 4, 10, 4).mean((1, 3))
    np.testing.assert_array_equal(smaller_mask(mask, 0.25), shares > 0.5)
    assert (shares == 0.5).any()
