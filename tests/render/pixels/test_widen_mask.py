import numpy as np

from caricli.render.pixels.widen_mask import widen_mask


def test_a_pixel_becomes_a_square():
    mask = np.zeros((9, 12), bool)
    mask[4, 0] = True
    expected = np.zeros_like(mask)
    expected[2:7, :3] = True
    np.testing.assert_array_equal(widen_mask(mask, 2), expected)
    np.testing.assert_array_equal(widen_mask(mask, 0), mask)
