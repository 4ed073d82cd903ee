"""Where along a jaw people mark its points."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.space_jaw import EVENLY, place_jaw, space_jaw
from caricli.structures.checks import number_problem, refuse
from caricli.structures.landmarks import COUNT, EYE_LEFT, EYE_RIGHT

INNER = len(EVENLY) - 2
"""Points of either side of the jaw between the ear and the chin."""


@dataclass(frozen=True, eq=False)
class JawPlaces:
    """Shares of the way from the ear to the chin, and from there to the other ear, told by the shape of a face.

    weight: (14, 136) and bias: (14,), of a linear map from what ``face_shape`` gives.
    """

    weight: np.ndarray
    bias: np.ndarray

    def __post_init__(self) -> None:
        """Raises InputError for numbers that are none, or other shapes."""
        for name, shape in (("weight", (2 * INNER, 2 * COUNT)), ("bias", (2 * INNER,))):
            array = getattr(self, name)
            refuse(number_problem(f"jaw's {name}", array))
            if array.shape != shape:
                raise InputError(f"jaw's {name}: expected {shape}, found {array.shape}")

    @classmethod
    def even(cls) -> "JawPlaces":
        """At equal distances, whatever the face."""
        return cls(np.zeros((2 * INNER, 2 * COUNT)), np.tile(EVENLY[1:-1], 2))

    def mark(self, points: np.ndarray) -> np.ndarray:
        """Landmarks (L, 2) with the jaw's points where people would mark them, on the same curve.

        Ears and chin stay where they are.
        """
        points = space_jaw(points)
        inner = (self.weight @ face_shape(points) + self.bias).reshape(2, INNER)
        inner = np.sort(np.clip(inner, 0, 1), axis=1)
        return place_jaw(points, np.pad(inner, ((0, 0), (1, 1)), constant_values=((0, 0), (0, 1))))


def face_shape(points: np.ndarray) -> np.ndarray:
    """(136,) the first 68 landmarks (L, 2), turned until the eyes are level, about their mean, in their diagonal."""
    points = points[:COUNT]
    across, down = points[list(EYE_LEFT)].mean(0) - points[list(EYE_RIGHT)].mean(0)
    turn = np.array([[across, -down], [down, across]]) / max(np.hypot(across, down), np.finfo(float).tiny)
    upright = (points - points.mean(0)) @ turn
    return (upright / max(np.linalg.norm(np.ptp(upright, axis=0)), np.finfo(float).tiny)).ravel()
