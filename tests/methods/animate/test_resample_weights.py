import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.animate.resample_weights import resample_weights
from caricli.structures import Track


def track(times, head=None):
    times = np.asarray(times, float)
    return Track(("a", "b"), times, np.stack([0.1 * times, 0.5 - 0.2 * times], 1), head)


def test_an_even_track_stays_as_it_is():
    given = track(np.arange(20) / 24)
    found, fps = resample_weights(given)
    assert found is given and fps == pytest.approx(24)


def test_what_is_linear_in_time_stays_so_at_any_rate():
    given = track([0, 0.05, 0.3, 0.31, 1.0])
    for fps in (10, 24, 60.0):
        found, rate = resample_weights(given, fps)
        assert rate == fps and len(found.times) == int(fps) + 1
        np.testing.assert_allclose(found.times, np.arange(len(found.times)) / fps)
        np.testing.assert_allclose(found.weights, track(found.times).weights, atol=1e-12)


def test_rounding_takes_no_frame_away():
    assert 0.29 * 100 < 29
    assert len(resample_weights(track([0, 0.1, 0.29]), 100)[0].times) == 30


def test_uneven_frames_become_even_at_their_usual_rate():
    times = np.delete(np.arange(31) / 30, [4, 5, 17])
    found, fps = resample_weights(track(times))
    assert fps == pytest.approx(30) and len(found.times) == 31
    np.testing.assert_allclose(found.weights, track(np.arange(31) / 30).weights, atol=1e-9)


def test_a_head_turns_the_short_way_over_half_a_turn():
    head = np.array([[3.1, 0, 0], [-3.1, 0, 0]])
    found, _ = resample_weights(track([0, 1], head), 2)
    assert np.cos(found.head[1, 0]) == pytest.approx(-1)


def test_one_frame_is_one_frame():
    found, fps = resample_weights(track([0.0]))
    assert len(found.times) == 1 and fps == 30
    assert len(resample_weights(track([0.0]), 5)[0].times) == 1


def test_endless_tracks_are_refused_before_they_are_made():
    with pytest.raises(InputError, match="1e.09 seconds"):
        resample_weights(Track(("a",), np.array([0, 1e9]), np.zeros((2, 1))), 30)


def test_stamps_of_whole_milliseconds_do_not_change_the_rate():
    times = np.delete(np.round(np.arange(91) * 1000 / 30) / 1000, [40, 41, 60])
    found, fps = resample_weights(track(times))
    assert fps == pytest.approx(30, abs=0.01)
    np.testing.assert_allclose(found.weights, track(found.times).weights, atol=1e-9)


def test_jitter_leaves_an_even_track():
    times = np.arange(150) / 60
    times[1:-1] += np.random.default_rng(2).uniform(-0.006, 0.006, 148)
    found, fps = resample_weights(track(times))
    assert fps == pytest.approx(60, rel=0.01)
    np.testing.assert_allclose(np.diff(found.times), 1 / fps)
