"""The One-Euro filter: calm where little moves, quick where much does (Casiez, Roussel and Vogel, CHI 2012)."""

import numpy as np

_CUTOFF = 2.0
"""Hertz: cutoff where nothing moves; at strength 1 two thirds of a still face's tremor at 60 Hz goes."""

_SPEED = 2.0
"""Hertz by weight per second: how much the cutoff grows with the speed, so that a blink passes."""

_SPEED_CUTOFF = 1.0
"""Hertz: cutoff of the speed itself, as in the paper."""


def smooth_weights(values: np.ndarray, times: np.ndarray, strength: float = 1.0) -> np.ndarray:
    """Filter every column by itself, forwards in time.

    A low-pass filter of first order whose cutoff is ``min_cutoff + beta |speed|``, the speed itself filtered at 1 Hz.
    ``min_cutoff = 2 / strength`` Hz and ``beta = 2 / strength`` Hz by weight per second: at 1 two thirds of a still
    face's tremor at 60 Hz goes and a blink passes; 2 is calmer, 0 is off.

    values: (T, N). times: (T,) seconds, rising. strength: 0 or more.
    Returns (T, N) float64; the first row as it is.
    """
    smooth = np.array(values, float)
    if not strength:
        return smooth
    speed = np.zeros(smooth.shape[1:])
    for k, step in enumerate(np.diff(times), 1):
        change = values[k] - smooth[k - 1]
        speed += _share(_SPEED_CUTOFF, step) * (change / step - speed)
        cutoff = (_CUTOFF + _SPEED * np.abs(speed)) / strength
        smooth[k] = smooth[k - 1] + _share(cutoff, step) * change
    return smooth


def _share(cutoff: np.ndarray | float, step: float) -> np.ndarray | float:
    """How much of a new value a low-pass filter of a cutoff (Hz) takes after a step (s)."""
    turn = 2 * np.pi * cutoff * step
    return turn / (turn + 1)
