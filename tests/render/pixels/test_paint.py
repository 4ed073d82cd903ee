import numpy as np

from caricli.render.pixels.paint import mix


def test_a_mix_goes_from_one_colour_to_the_other():
    first, second = np.array([10.0, 20, 30]), np.array([30.0, 20, 10])
    share = np.array([[0.0, 0.25], [0.5, 1.0]])
    np.testing.assert_allclose(mix(first, second, share)[..., 0], [[10, 15], [20, 30]])
    np.testing.assert_allclose(mix(np.stack([first, second]), second, 0.5), [[20, 20, 20], second])
