import numpy as np
import pytest

from caricli.geometry.smooth_step import smooth_step


@pytest.mark.parametrize(("start", "end"), [(1.0, 3.0), (3.0, 1.0)])
def test_a_step_is_flat_outside_and_half_in_the_middle(start, end):
    value = np.array([start - 2 * (end - start), start, 2.0, end, end + 2 * (end - start)])
    np.testing.assert_allclose(smooth_step(value, start, end), [0, 0, 0.5, 1, 1])
    steps = np.diff(smooth_step(np.linspace(start, end, 50), start, end))
    assert (steps > 0).all() and steps[0] < 0.2 * steps.max() > steps[-1]
