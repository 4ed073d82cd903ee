"""Landmarks of a caricature to those of a normal face, or back."""

import numpy as np

from caricli.errors import InputError
from caricli.limits import MAX_COORDINATE
from caricli.models.landmark_map.model import LandmarkMap
from caricli.structures.checks import number_problem
from caricli.structures.landmarks import COUNT


def map_landmarks(
    points: np.ndarray, landmark_map: LandmarkMap, to: str, style: np.ndarray | None = None
) -> np.ndarray:
    """Map the 68 iBUG landmarks of a face; eyes and mouth keep place, size and turn.

    points: (L, 2) pixels, y down; what comes after the 68 is left out. landmark_map: LandmarkMap. to: "normal" or
    "caricature". style: (D,) of the caricature, or None for the likeliest.
    Returns (68, 2). Raises InputError where a landmark is not known, eyes and mouth lie in one place, or the points are
    so far from a face's that they are mapped beyond MAX_COORDINATE.
    """
    unknown = np.flatnonzero(np.isnan(points[:COUNT]).any(axis=1))
    if len(points) < COUNT or len(unknown):
        count = f"{len(points)}" if len(points) < COUNT else f"{COUNT - len(unknown)}, not landmark {unknown[0]}"
        raise InputError(f"expected all {COUNT} landmarks to be known, found {count}")
    mapped = landmark_map.map(points[:COUNT], to, style)
    if number_problem("", mapped, MAX_COORDINATE):
        raise InputError(f"expected the landmarks of a face, found points that a {to} face would have far outside")
    return mapped


def mean_shift(points: np.ndarray, mapped: np.ndarray) -> float:
    """How far the 68 landmarks moved on average, in percent of the diagonal of the given ones.

    points: (L, 2) as given to ``map_landmarks``. mapped: (68, 2) what came of them.
    """
    moved = np.linalg.norm(mapped - points[:COUNT], axis=1).mean()
    return float(100 * moved / np.linalg.norm(np.ptp(points[:COUNT], axis=0)))
