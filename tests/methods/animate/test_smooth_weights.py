import numpy as np
import pytest

from caricli.methods.animate.smooth_weights import smooth_weights

TIMES = np.arange(120) / 60


def test_without_strength_nothing_changes_and_the_input_never_does():
    values = np.random.default_rng(1).normal(size=(120, 3))
    before = values.copy()
    np.testing.assert_array_equal(smooth_weights(values, TIMES, 0), values)
    smooth_weights(values, TIMES, 1)
    np.testing.assert_array_equal(values, before)


def test_what_does_not_move_stays():
    values = np.tile([0.0, 0.3, 1.0], (120, 1))
    np.testing.assert_array_equal(smooth_weights(values, TIMES, 2), values)


@pytest.mark.parametrize("strength", [0.5, 1, 3])
def test_a_step_is_followed_monotonically_without_overshoot(strength):
    values = np.where(TIMES < 0.5, 0.2, 0.9)[:, None]
    out = smooth_weights(values, TIMES, strength)[:, 0]
    assert (np.diff(out) >= 0).all() and out[0] == 0.2 and out.max() <= 0.9
    assert out[30] < 0.9 - 1e-3 and out[-1] > 0.899


def test_more_strength_is_calmer_and_later():
    generator = np.random.default_rng(3)
    noisy = 0.5 + 0.01 * generator.normal(size=(120, 1))
    step = np.where(TIMES < 0.5, 0.0, 1.0)[:, None]
    tremor = [smooth_weights(noisy, TIMES, s)[20:].std() for s in (0, 0.5, 1, 2)]
    late = [smooth_weights(step, TIMES, s).sum() for s in (0, 0.5, 1, 2)]
    assert tremor == sorted(tremor, reverse=True) and tremor[2] < tremor[0] / 2
    assert late == sorted(late, reverse=True)


def test_a_blink_passes_where_a_tremor_does_not():
    blink = np.interp(TIMES, [0.5, 0.6, 0.75, 0.9], [0, 1, 1, 0])[:, None]
    assert smooth_weights(blink, TIMES, 1).max() > 0.98


def test_columns_do_not_know_of_each_other_and_time_is_seconds():
    values = np.random.default_rng(2).random((120, 2))
    both = smooth_weights(values, TIMES, 1)
    np.testing.assert_array_equal(both[:, 1:], smooth_weights(values[:, 1:], TIMES, 1))
    # Twice the time between the samples leaves less of what came before.
    slow = smooth_weights(values, 2 * TIMES, 1)
    assert np.abs(slow - values).mean() < np.abs(both - values).mean()


def test_it_is_the_published_filter():
    values, times = np.array([[0.1], [0.4], [0.5], [0.2]]), np.array([0, 0.1, 0.15, 0.3])
    out, speed, kept = [0.1], 0.0, 0.1
    for k in range(1, 4):
        step = times[k] - times[k - 1]
        share = 1 / (1 + 1 / (2 * np.pi * 1.0 * step))
        speed = share * (values[k, 0] - kept) / step + (1 - share) * speed
        share = 1 / (1 + 1 / (2 * np.pi * (2 + 2 * abs(speed)) * step))
        kept = share * values[k, 0] + (1 - share) * kept
        out.append(kept)
    np.testing.assert_allclose(smooth_weights(values, times, 1)[:, 0], out, rtol=1e-12)
