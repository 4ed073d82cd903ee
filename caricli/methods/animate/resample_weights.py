"""A track of weights at an even frame rate."""

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.rows_at import rows_at
from caricli.io.takes.track import MAX_FRAMES, MAX_WEIGHTS
from caricli.methods.animate.turn_head import within_half_turns
from caricli.structures import Track

_EVEN = 1e-3
"""Seconds that a frame may be early or late in a track that counts as even."""

_GAP = 1.75
"""Usual steps that are a gap: a lost frame makes two of them, jitter of a third of a frame less than this."""

_ROUNDING = 1e-6
"""Frames that the last one may lack."""


def resample_weights(track: Track, fps: float | None = None) -> tuple[Track, float]:
    """Sample a track at even times, linearly in between; angles go on over half turns.

    fps: frames per second; where absent the track's own, by the mean of its steps without gaps, and a track whose
    frames are even already stays as it is.
    Returns Track and its frames per second. Raises InputError when that is too many frames.
    """
    steps = np.diff(track.times)
    own = 1 / _usual_step(steps) if len(steps) else track.fps
    if fps is None:
        mean = len(steps) / track.times[-1] if len(steps) else own
        if not len(steps) or np.abs(track.times - np.arange(len(track.times)) / mean).max() < _EVEN:
            return track, mean
        fps = own
    count = np.floor(track.times[-1] * fps + _ROUNDING) + 1
    if count > MAX_FRAMES or count * len(track.names) > MAX_WEIGHTS:
        length = f"{track.times[-1]:g} seconds at {fps:g} frames a second"
        raise InputError(f"weights: expected at most {MAX_FRAMES} frames and {MAX_WEIGHTS} weights, found {length}")
    times = np.arange(int(count)) / fps
    head = None
    if track.head is not None:
        angles = np.unwrap(track.head, axis=0)
        head = within_half_turns(rows_at(times, track.times, angles))
    return Track(track.names, times, rows_at(times, track.times, track.weights), head), fps


def _usual_step(steps: np.ndarray) -> float:
    """Seconds from frame to frame: the mean, which jitter and whole milliseconds do not move, of what is no gap."""
    median = np.sort(steps)[(len(steps) - 1) // 2]
    return float(steps[steps < _GAP * median].mean())
