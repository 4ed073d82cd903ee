"""The outline of a face among strokes that no curve was found for."""

from collections.abc import Sequence

import numpy as np

_FEATURES = 3
"""Lines that an outline goes around, at least."""


def find_outline(lines: Sequence[np.ndarray], features: Sequence[np.ndarray]) -> int | None:
    """The smallest line that goes around all features, as a jaw does: as wide, below them, and up to their middle.

    Jaws of caricatures may be far from any face's. lines: of (N, 2) pixels, y down. features: of (N, 2), what else of
    the face is drawn.
    Returns the number of the line, or None, also where few features are drawn.
    """
    if len(features) < _FEATURES:
        return None
    inner = np.concatenate(features)
    least, most = inner.min(0), inner.max(0)
    middle = (least[1] + most[1]) / 2
    around = {}
    for number, line in enumerate(lines):
        low, high = line.min(0), line.max(0)
        if low[0] <= least[0] and (high >= most).all() and low[1] <= middle:
            around[number] = float((high - low).sum())
    return min(around, key=lambda number: around[number], default=None)
