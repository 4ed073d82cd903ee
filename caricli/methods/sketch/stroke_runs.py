"""Where along a stroke what it draws changes."""

import numpy as np


def stroke_runs(logs: np.ndarray, change: float) -> list[tuple[int, int]]:
    """Runs (start, end) of the likeliest classes of places in a row (Viterbi), which cover all places.

    logs: (N, C) logarithms of the chances of classes, N at least 1. change: what every change of the class costs.
    """
    count, classes = logs.shape
    best = logs[0]
    before = np.zeros((count, classes), int)
    for place in range(1, count):
        likeliest = int(best.argmax())
        changes = best < best[likeliest] - change
        before[place] = np.where(changes, likeliest, np.arange(classes))
        best = np.maximum(best, best[likeliest] - change) + logs[place]
    path = np.zeros(count, int)
    path[-1] = best.argmax()
    for place in range(count - 1, 0, -1):
        path[place - 1] = before[place, path[place]]
    starts = [0, *(np.flatnonzero(np.diff(path)) + 1).tolist()]
    return list(zip(starts, [*starts[1:], count], strict=True))
