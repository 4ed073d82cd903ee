"""Points of the jaw, along it."""

from collections.abc import Callable

import numpy as np

from caricli.structures.landmarks import JAW, POINT_NAMES

_LEAST = 1e-6
"""Distance that two neighbours have at least, of the jaw's length."""

_USUAL = (0, 0.0794, 0.2330, 0.3832, 0.5235, 0.6484, 0.7556, 0.9031, 1)
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
    from_ear = np.array(_USUAL)
    points = points.copy()
    for side, places in zip(_SIDES, (from_ear, 1 - from_ear[::-1]), strict=True):
        points[side] = _curve(places, points[side])(EVENLY)
    return points


def jaw_shares(points: np.ndarray) -> np.ndarray:
    """(2, 9) shares of the way to the chin, and from there, at which a jaw's points stand. points: (L, 2)."""
    lengths = [_lengths(points[side]) for side in _SIDES]
    return np.stack([along / along[-1] for along in lengths])


def place_jaw(points: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) whose jaw's points are moved along it. shares: (2, 9) as ``jaw_shares`` gives them."""
    points = points.copy()
    for side, own in zip(_SIDES, shares, strict=True):
        along = _lengths(points[side])
        points[side] = _curve(along, points[side])(own * along[-1])
    return points


def _lengths(curve: np.ndarray) -> np.ndarray:
    """(K,) way along a curve (K, 2) to each of its points; two that fall together are a little apart."""
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    steps = np.maximum(steps, max(_LEAST * steps.sum(), np.finfo(float).tiny))
    return np.concatenate([[0], np.cumsum(steps)])


def _curve(places: np.ndarray, points: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(places, points)
