"""Points of the jaw, along it."""

import numpy as np

from caricli.geometry.lines.slide_points import line_shares, slide_points
from caricli.structures.landmarks import JAW, POINT_NAMES

_USUAL = np.array([0, 0.0794, 0.2330, 0.3832, 0.5235, 0.6484, 0.7556, 0.9031, 1])
"""Shares of the way from an ear to the chin of the jaw's vertices, on the default head, seen from the front."""

_SIDES = (slice(JAW.start, POINT_NAMES["chin"] + 1), slice(POINT_NAMES["chin"], JAW.stop))

EVENLY = np.linspace(0, 1, len(_USUAL))
"""Shares of the way at which points stand at equal distances."""


def space_jaw(points: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) whose jaw's points stand at equal distances along it, on either side from the ear to the chin.

    So they are marked by hand on usual faces (iBUG; Sagonas et al. 2013), because the jaw has nothing else to know them
    by. Ears and chin stay where they are.
    """
    return place_jaw(points, np.stack([EVENLY, EVENLY]))


def carry_jaw(points: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) of a mesh, the jaw's where its shape has carried what stands at equal distances on a usual head.

    So they are marked by hand in drawings: points keep their places on the face, and where a chin is large they are
    farther apart. The mesh's own are vertices, which lie nearer to the chin. Ears and chin stay where they are.
    """
    points = points.copy()
    for side, vertices in zip(_SIDES, (_USUAL, 1 - _USUAL[::-1]), strict=True):
        points[side] = slide_points(points[side], EVENLY, vertices)
    return points


def jaw_shares(points: np.ndarray) -> np.ndarray:
    """(2, 9) shares of the way to the chin, and from there, at which a jaw's points stand. points: (L, 2)."""
    return np.stack([line_shares(points[side]) for side in _SIDES])


def place_jaw(points: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) whose jaw's points are moved along it. shares: (2, 9) as ``jaw_shares`` gives them."""
    points = points.copy()
    for side, own in zip(_SIDES, shares, strict=True):
        points[side] = slide_points(points[side], own)
    return points
