"""A line in pieces."""

from collections.abc import Sequence

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.rows_at import rows_at


def cut_line(line: np.ndarray, cuts: Sequence[float], carried: np.ndarray | None = None) -> list[np.ndarray]:
    """Pieces (M, D) of a line (N, D) between cuts, each of which begins where the one before ends.

    cuts: ascending, shares of the line's length. carried: (N,) or (N, A), what is known at its points, which then
    stands in further columns (M, D + A) of the pieces, for (N,) in one; or None.
    """
    reached = arc_lengths(line)
    rows = line if carried is None else np.column_stack([line, carried])
    ends = reached[-1] * np.array([0.0, *cuts, 1.0])
    corners = rows_at(ends, reached, rows)
    inner = [rows[(reached > start) & (reached < end)] for start, end in zip(ends, ends[1:], strict=False)]
    return [np.vstack([corners[k], points, corners[k + 1]]) for k, points in enumerate(inner)]
