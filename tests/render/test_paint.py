import numpy as np
import pytest

from caricli.render.paint import mix, smooth_step


@pytest.mark.parametrize(("start", "end"), [(1.0, 3.0), (3.0, 1.0)])
def test_a_step_is_flat_outside_and_half_in_the_middle(start, end):
    value = np.array([start - 2 * (end - start), start, 2.0, end, end + 2 * (end - start)])
    np.testing.assert_allclose(smooth_step(value, start, end), [0, 0, 0.5, 1, 1])
    steps = np.diff(smooth_step(np.linspace(start, end, 50), start, end))
    assert (steps > 0).all() and steps[0] < 0.2 * steps.max() > steps[-1]


def test_a_mix_goes_from_one_colour_to_the_other():
    first, second = np.array([10.0, 20, 30]), np.array([30.0, 20, 10])
    share = np.array([[0.0, 0.25], [0.5, 1.0]])
    np.testing.assert_allclose(mix(first, second, share)[..., 0], [[10, 15], [20, 30]])
    np.testing.assert_allclose(mix(np.stack([first, second]), second, 0.5), [[20, 20, 20], second])
