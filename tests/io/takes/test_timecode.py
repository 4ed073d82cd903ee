import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.takes.timecode import NTSC, timecode_seconds


def labelled(number, labels, drop, mark=":"):
    """SMPTE's timecode of the frame of a number, counted from midnight, the slow and plain way."""
    hour = minute = second = frame = 0
    for _ in range(number):
        frame += 1
        if frame == labels:
            second += 1
            frame = 0
        if second == 60:
            minute += 1
            second = 0
            frame = drop if minute % 10 else 0
        if minute == 60:
            hour += 1
            minute = 0
    return f"{hour:02d}:{minute:02d}:{second:02d}{mark}{frame:02d}"


def take(first, count, labels, drop, mark=":"):
    return [labelled(first + k, labels, drop, mark) for k in range(count)]


@pytest.mark.parametrize(("labels", "drop"), [(60, 4), (30, 2)])
@pytest.mark.parametrize("mark", [":", ";"])
@pytest.mark.parametrize("minute", [1, 9, 10])
def test_drop_frame_runs_evenly_over_minutes(labels, drop, mark, minute):
    first = 60 * labels * minute - drop * (minute - 1 - (minute - 1) // 10) - 2 * labels
    timecodes = take(first, 4 * labels, labels, drop, mark)
    assert any(f":{minute:02d}:00" in timecode for timecode in timecodes)
    if minute == 10 and mark == ":":
        # Nothing is left out at full ten minutes, so nothing tells them from the plain rate.
        return
    times = timecode_seconds(timecodes, None, 60.0)
    np.testing.assert_allclose(times, np.arange(len(times)) / (labels * NTSC), atol=1e-9)


def test_a_rate_that_is_given_counts_the_frames_of_every_second():
    timecodes = take(50, 200, 60, 0)
    times = timecode_seconds(timecodes, 59.94, 60.0)
    np.testing.assert_allclose(times, np.arange(200) / 59.94, atol=1e-9)
    times = timecode_seconds(take(60 * 1800 - 2 * 59, 90, 30, 2), 30 * NTSC, 60.0)
    np.testing.assert_allclose(times, np.arange(90) / (30 * NTSC), atol=1e-9)
    np.testing.assert_allclose(timecode_seconds(take(50, 300, 100, 0), 100, 60.0), np.arange(300) / 100, atol=1e-9)


@pytest.mark.parametrize(("labels", "fps"), [(24, 25), (25, 30), (30, 24), (30, 60), (60, 30), (60, 29.97)])
def test_a_rate_that_a_second_contradicts_is_refused(labels, fps):
    with pytest.raises(InputError, match=f"expected --source-fps {labels}, as the timecodes count, found {fps}"):
        timecode_seconds(take(50, 3 * labels, labels, 0), fps, 60.0)
    # Within a second nothing contradicts, and timecodes in no order say nothing.
    assert timecode_seconds(take(0, 10, labels, 0), fps, 60.0)[-1] == pytest.approx(9 / fps)
    assert timecode_seconds(["10:00:09:00", "10:00:01:00", "10:00:10:00"], fps, 60.0)[-1] == pytest.approx(2 / fps)


def test_frames_that_were_lost_stay_lost():
    timecodes = take(7000, 400, 60, 4, ";")
    kept = np.delete(np.arange(400), [3, 4, 5, 200, 201])
    times = timecode_seconds([timecodes[k] for k in kept], None, 60.0)
    np.testing.assert_allclose(times, kept / (60 * NTSC), atol=1e-9)


def test_jitter_is_put_in_order_within_a_frame_or_two():
    frames = np.arange(600)
    generator = np.random.default_rng(3)
    seen = np.round(frames + generator.normal(0, 0.6, len(frames))).astype(int) + 100
    seen[0], seen[-1] = 100, 699
    times = timecode_seconds([labelled(k, 60, 0) for k in seen], None, 60.0)
    assert (np.diff(times) > 0).all() and np.abs(times - frames / 60).max() < 3 / 60
    # A single repetition moves nothing but its own neighbourhood.
    repeated = [*frames[:50], 49, *frames[51:]]
    times = timecode_seconds([labelled(k, 60, 0) for k in repeated], None, 60.0)
    np.testing.assert_allclose(times, frames / 60, atol=0.6 / 60)


def test_midnight_and_rubbish():
    times = timecode_seconds(["23:59:59:58", "23:59:59:59", "00:00:00:00", "00:00:00:02"], None, 60.0)
    np.testing.assert_allclose(times, np.array([0, 1, 2, 4]) / 60, atol=1e-9)
    for timecodes in (
        ["10:00:00:01", "?", "10:00:00:03"],
        ["10:00:00:05"] * 3,
        ["10:00:09:00", "10:00:01:00", "10:00:10:00"],
    ):
        np.testing.assert_allclose(timecode_seconds(timecodes, None, 50.0), np.arange(3) / 50)


def test_of_drop_frame_the_rate_that_is_told_counts():
    assert timecode_seconds(["01:00:00;00", "01:00:00;30"], 60, 30).tolist() == [0, 0.5]
