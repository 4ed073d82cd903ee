"""Strokes of which a face has one on either side: they draw nothing that lies across its middle."""

from collections.abc import Sequence

import numpy as np

from caricli.geometry.lines.match_line import resample
from caricli.structures.sketch import Stroke

_POINTS = 16
"""Of a stroke, that are compared."""
_ALIKE = 0.15
"""Of their size: as near to each other's mirror image two strokes are."""
_APART = 0.5
"""Of their width: the gap between them, at least; halves of a mouth meet."""


def mirrored_strokes(strokes: Sequence[Stroke]) -> np.ndarray:
    """(S,) bool: whether another stroke beside it is about the mirror image of a stroke, and does not meet it.

    strokes: of some length, pixels.
    """
    mirrored = np.zeros(len(strokes), bool)
    if len(strokes) < 2:
        return mirrored
    lines = np.array([resample(stroke.points, _POINTS) for stroke in strokes])
    low, high = lines.min(1), lines.max(1)
    size = high - low
    extent = np.maximum(np.linalg.norm(size, axis=1), 1e-9)
    larger = np.maximum(extent[:, None], extent)
    gap = low[None, :, 0] - high[:, None, 0]
    beside = (gap > _APART * np.maximum(size[:, None, 0], size[:, 0])) & (gap > _ALIKE * larger)
    level = np.abs(low[:, None, 1] - low[:, 1]) + np.abs(high[:, None, 1] - high[:, 1]) < 2 * _ALIKE * larger
    for a, b in np.argwhere(beside & level & (np.abs(size[:, None, 0] - size[:, 0]) < _ALIKE * larger)):
        image = [low[a, 0] + high[b, 0], 0] + lines[b] * [-1, 1]
        apart = min(np.linalg.norm(lines[a] - way, axis=1).mean() for way in (image, image[::-1]))
        if apart < _ALIKE * larger[a, b]:
            mirrored[[a, b]] = True
    return mirrored
