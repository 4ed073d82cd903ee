"""The One-Euro filter: calm where little moves, quick where much does (Casiez, Roussel and Vogel, CHI 2012)."""

import numpy as np

_CUTOFF, _SPEED = 2.0, 2.0
_SPEED_CUTOFF = 1.0


def smooth_weights(values, times, strength=1.0):
    """Filter every column by itself, forwards in time.

    A low-pass filter of first order whose cutoff is ``min_cutoff + beta |speed|``, the speed itself filtered at 1 Hz.
    ``min_cutoff = 2 / strength`` Hz and ``beta = 2 / strength`` Hz by weight per second: at 1 two thirds of a still
    face's tremor at 60 Hz goes and a blink passes; 2 is calmer, 0 is off.
    values: (T, N). times: (T,) seconds, rising. strength: 0 or more.
    Returns (T, N) float64; the first row as it is.
    """
    out = np.array(values, float)
    if not strength:
        return out
    speed = np.zeros(out.shape[1:])
    for k, step in enumerate(np.diff(times), 1):
        speed += _share(_SPEED_CUTOFF, step) * ((values[k] - out[k - 1]) / step - speed)
        out[k] = out[k - 1] + _share((_CUTOFF + _SPEED * np.abs(speed)) / strength, step) * (values[k] - out[k - 1])
    return out


def _share(cutoff, step):
    """How much of a new value a low-pass filter of a cutoff (Hz) takes after a step (s)."""
    turn = 2 * np.pi * cutoff * step
    return turn / (turn + 1)
