"""Landmarks of a caricature to those of a normal face, or back."""

import numpy as np

from caricli.errors import InputError
from caricli.models.landmark_map.model import COUNT


def map_landmarks(points, landmark_map, to):
    """Map the 68 iBUG landmarks of a face; eyes and mouth keep place, size and turn.

    points: (L, 2) pixels, y down; what comes after the 68 is left out. landmark_map: LandmarkMap. to: "normal" or
    "caricature".
    Returns (68, 2). Raises InputError where a landmark is not known, or eyes and mouth lie in one place.
    """
    unknown = np.flatnonzero(np.isnan(points[:COUNT]).any(axis=1))
    if len(points) < COUNT or len(unknown):
        found = f"{len(points)}" if len(points) < COUNT else f"{COUNT - len(unknown)}, not landmark {unknown[0]}"
        raise InputError(f"expected all {COUNT} landmarks to be known, found {found}")
    return landmark_map.map(points[:COUNT], to)
