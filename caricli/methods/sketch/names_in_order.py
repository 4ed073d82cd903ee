"""Names of curves that lie one below the other, by where their lines do."""

from collections.abc import Mapping

import numpy as np

from caricli.methods.sketch.settings import ORDERED

_PLACES = 7
"""Across two lines, at which they are compared."""


def names_in_order(lines: Mapping[str, np.ndarray], least: float) -> dict[str, str]:
    """The names that lines should have, by those that they have: brows over lids, lids and lips from above to below.

    lines: (N, 2) pixels, y down, by names of curves; others than those of ``ORDERED`` keep theirs. least: pixels that a
    line is below another for which they change their names.
    """
    right = {name: name for name in lines}
    for group in ORDERED:
        names = [name for name in group if name in lines]
        order = list(names)
        for _ in names:
            for upper in range(len(order) - 1):
                pair = order[upper : upper + 2]
                if _below(lines[pair[0]], lines[pair[1]]) > least:
                    order[upper : upper + 2] = pair[::-1]
        right |= dict(zip(order, names, strict=True))
    return right


def _below(line: np.ndarray, other: np.ndarray) -> float:
    """Pixels that a line (N, 2) is below another, in the middle of where both are; as a whole where none is."""
    low = max(line[:, 0].min(), other[:, 0].min())
    high = min(line[:, 0].max(), other[:, 0].max())
    if low >= high:
        return float(line[:, 1].mean() - other[:, 1].mean())
    places = np.linspace(low, high, _PLACES + 4)[2:-2]
    heights = [np.interp(places, *each[each[:, 0].argsort(kind="stable")].T) for each in (line, other)]
    return float(np.median(heights[0] - heights[1]))
