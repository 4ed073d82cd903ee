"""A step without corners."""

import numpy as np


def smooth_step(value: float | np.ndarray, start: float | np.ndarray, end: float | np.ndarray) -> np.ndarray:
    """0 before the start, 1 after the end, which may be the smaller one, smooth between them.

    value: a number or an array of any shape. start, end: numbers, or arrays like it.
    """
    t = np.clip((value - start) / (end - start), 0, 1)
    return t * t * (3 - 2 * t)
