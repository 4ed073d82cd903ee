"""A line in pieces."""

from collections.abc import Sequence

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.rows_at import rows_at


def cut_line(line: np.ndarray, cuts: Sequence[float]) -> list[np.ndarray]:
    """Pieces (M, D) of a line (N, D) between cuts, each of which begins where the one before ends.

    cuts: ascending, shares of the line's length.
    """
    reached = arc_lengths(line)
    ends = reached[-1] * np.array([0.0, *cuts, 1.0])
    corners = rows_at(ends, reached, line)
    inner = [line[(reached > start) & (reached < end)] for start, end in zip(ends, ends[1:], strict=False)]
    return [np.vstack([corners[k], points, corners[k + 1]]) for k, points in enumerate(inner)]
