import numpy as np

from caricli.render.pixels.srgb import to_linear, to_srgb


def test_one_undoes_the_other():
    values = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(to_srgb(to_linear(values)), values, atol=1e-6)
    np.testing.assert_allclose(to_linear(np.array([0.5])), 0.21404, atol=1e-5)


def test_what_is_beyond_is_cut_off():
    np.testing.assert_array_equal(to_linear(np.array([-1.0, 2.0])), [0, 1])
    np.testing.assert_array_equal(to_srgb(np.array([-1.0])), [0])
