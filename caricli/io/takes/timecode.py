"""SMPTE timecodes of a take to seconds: whole and NTSC rates, drop-frame, jitter, midnight."""

import re
from collections.abc import Sequence

import numpy as np

from caricli.errors import InputError

COMMON = (24, 25, 30, 48, 50, 60, 90, 120, 240)
"""Frames that a second of timecode can have."""

NTSC = 1000 / 1001
"""How much slower than its timecode says a recording at 23.976, 29.97 or 59.94 frames a second runs."""

_TIMECODE = re.compile(r"(\d{1,2}):(\d{1,2}):(\d{1,2})([:;])(\d{1,4}(?:\.\d{1,9})?)", re.ASCII)
_DAY = 86400.0
_BACK = 0.5
"""Seconds that timecodes may go back: a tracker's clock and the camera's disagree by some frames, not by more."""


def timecode_seconds(timecodes: Sequence[str], fps: float | None, usual: float) -> np.ndarray:
    """Seconds (T,), rising from 0, of timecodes HH:MM:SS:FF.fff, which count frames at a rate that they do not hold.

    The rate is ``fps``, else the smallest of COMMON above the frames counted where a second ends within the take, else
    ``usual``. A timecode with ";" before its frames, or whose minutes begin at frame 2 (of 30) or 4 (of 60), is of
    drop-frame: frames run at 1000/1001 of the rate, and the numbers left out keep the count with the clock. Timecodes
    that repeat, or step back a little, are jitter: those in one place share the time up to the next. Over midnight
    times go on. Where timecodes are no such text, all the same, or far from order, rows follow each other at the rate.
    Raises InputError where a second ends within the take and shows another rate than ``fps``.
    """
    rate = fps or usual
    rows = np.arange(len(timecodes)) / rate
    matches = [match for match in map(_TIMECODE.fullmatch, timecodes) if match]
    if len(matches) < len(timecodes):
        return rows
    hours, minutes, seconds, frames = np.array([[float(match[k]) for k in (1, 2, 3, 5)] for match in matches]).T
    clock = 3600 * hours + 60 * minutes + seconds
    clock += _DAY * np.cumsum(np.diff(clock, prepend=clock[0]) < -_DAY / 2)
    labels = told = np.ceil(rate - 1e-6)
    if clock[0] != clock[-1]:
        # A take that goes over a second's end shows how many frames a second has.
        top = np.floor(frames.max()) + 1
        counted = next((common for common in COMMON if common >= top), top)
        if fps is None or not top <= told <= counted:
            rate = labels = counted
    count = labels * clock + frames
    if matches[0][4] == ";" or _skips(clock, frames, labels):
        minute = clock // 60
        count -= _dropped(labels) * (minute - minute // 10)
        rate = labels * NTSC if fps is None else rate
    times = _in_order((count - count[0]) / rate)
    if times is None:
        return rows
    if fps is not None and labels != told:
        raise InputError(f"expected --source-fps {labels:g}, as the timecodes count, found {fps:g}")
    return times


def _dropped(labels: float) -> float:
    """Numbers that drop-frame leaves out at the beginning of nine minutes of ten."""
    return 2 * np.ceil(labels / 30)


def _skips(clock: np.ndarray, frames: np.ndarray, labels: float) -> bool:
    """Whether a take's minutes begin at the first number that drop-frame leaves."""
    first = _dropped(labels)
    begins = np.flatnonzero((np.diff(clock // 60) == 1) & (clock[1:] % 60 == 0) & (clock[1:] // 60 % 10 != 0)) + 1
    if labels % 30 or not len(begins):
        return False
    late = (frames[begins] >= first) & (frames[begins] < first + 1)
    return bool((late & (np.floor(frames[begins - 1]) == labels - 1)).all())


def _in_order(times: np.ndarray) -> np.ndarray | None:
    """Times that rise, those in one place spread up to the next; None where they are too far from order."""
    highest = np.maximum.accumulate(times)
    if len(times) == 1:
        return times
    if times[-1] <= 0 or (highest - times).max() > _BACK:
        return None
    places, start = np.unique(highest, return_index=True)
    step = float(np.median(np.diff(places)))
    ends = np.append(start, len(times))
    return np.interp(np.arange(len(times)), ends, np.append(places, places[-1] + step * (ends[-1] - ends[-2])))
