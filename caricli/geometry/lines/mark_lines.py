"""Points along brows, nose and lips, where people mark them."""

import numpy as np

from caricli.geometry.lines.slide_points import slide_points
from caricli.structures.landmarks import BRIDGE, BROW_LEFT, BROW_RIGHT, NOSTRILS

_UPPER = range(48, 55)
_LOWER = (*range(54, 60), 48)
_UPPER_INSIDE = range(60, 65)
_LOWER_INSIDE = (*range(64, 68), 60)

_MARKED = {
    BROW_RIGHT: (0.23, 0.48, 0.74),
    BROW_LEFT: (0.26, 0.52, 0.77),
    BRIDGE: (0.33, 0.67),
    NOSTRILS: (0.25, 0.5, 0.75),
    _UPPER: (0.19, 0.37, 0.5, 0.63, 0.81),
    _LOWER: (0.21, 0.38, 0.5, 0.62, 0.79),
    _UPPER_INSIDE: (0.34, 0.5, 0.66),
    _LOWER_INSIDE: (0.34, 0.5, 0.66),
}
"""Shares of a line's length at which its inner points stand in the mean face of people who were marked by hand.

Of photographs of iBUG 300-W (Sagonas et al. 2013), as dlib's detector learnt it and OpenFace prints it (``TEMPLATE`` of
``align_dlib.py``), the mean of both sides, to two digits.
"""


def mark_lines(points: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) whose points along brows, nose and lips stand where people mark them.

    Ends stay where they are, and so do lids and jaw, and lines of which a point is not known (NaN).
    """
    points = points.copy()
    for numbers, inner in _MARKED.items():
        line = points[list(numbers)]
        if np.isfinite(line).all():
            points[list(numbers)] = slide_points(line, np.array([0, *inner, 1]))
    return points
