"""Where hair ends on a head."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

_STEPS = 24  # rows that the edge may rise or fall from one column to the next


def find_edge(votes: np.ndarray, steady: float) -> np.ndarray:
    """The edge with the most votes, one row for every column: what is above it is hair.

    Maximises ``sum_c (sum_{r < e_c} votes_rc - steady |e_c - e_{c+1}|)`` around the head, by dynamic programming.

    votes: (R, C), above zero where there is hair, below where there is none. steady: votes that a step costs.
    Returns (C,) int, from 0 to R.
    """
    rows, columns = votes.shape
    gains = np.vstack([np.zeros(columns), np.cumsum(votes, axis=0)])
    # The column where most is said begins, its edge fixed, so that the way around ends where it began.
    first = int(np.abs(votes).sum(0).argmax())
    gains = np.roll(gains, -first, axis=1)
    start = int(gains[:, 0].argmax())
    score = np.full(rows + 1, -np.inf)
    score[start] = gains[start, 0]
    came = np.zeros((columns, rows + 1), int)
    most = min(_STEPS, rows)
    steps = np.arange(-most, most + 1)
    costs = steady * np.abs(steps)
    # Of every row those that it can be reached from, in the order of steps.
    padded = np.full(rows + 1 + 2 * most, -np.inf)
    from_there = sliding_window_view(padded, len(steps))[:, ::-1]
    for column in range(1, columns):
        padded[most : most + rows + 1] = score
        around = from_there - costs
        best = around.argmax(1)
        came[column] = steps[best]
        score = around[np.arange(rows + 1), best] + gains[:, column]
    last = score - steady * np.abs(np.arange(rows + 1) - start)
    edge = np.zeros(columns, int)
    edge[-1] = int(last.argmax())
    for column in range(columns - 1, 0, -1):
        edge[column - 1] = edge[column] - came[column, edge[column]]
    return np.roll(edge, first)
