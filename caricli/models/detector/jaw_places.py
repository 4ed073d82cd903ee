"""Where along a jaw people mark its points."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.space_jaw import EVENLY, place_jaw, space_jaw
from caricli.models.detector.usual_shapes import UsualShapes
from caricli.structures.checks import number_problem, refuse
from caricli.structures.landmarks import COUNT, EYE_LEFT, EYE_RIGHT

INNER = len(EVENLY) - 2
"""Points of either side of the jaw between the ear and the chin."""

_USUAL = (1.5, 3.0)
"""Squared distances, see UsualShapes, up to which a face is usual, and from which on it is not. Of generated faces
three quarters that are not exaggerated are nearer than 1.9, and 19 of 20 with parts of other sizes farther than 2.8."""


@dataclass(frozen=True, eq=False)
class JawPlaces:
    """Shares of the way from the ear to the chin, and from there to the other ear, told by the shape of a face.

    weight: (14, 136) and bias: (14,), of a linear map from what ``face_shape`` gives. usual: UsualShapes of the same:
    jaws of usual faces are marked at equal distances (iBUG; Sagonas et al. 2013); or None where all are told.
    """

    weight: np.ndarray
    bias: np.ndarray
    usual: UsualShapes | None = None

    def __post_init__(self) -> None:
        """Raises InputError for numbers that are none, or other shapes."""
        for name, shape in (("weight", (2 * INNER, 2 * COUNT)), ("bias", (2 * INNER,))):
            array = getattr(self, name)
            refuse(number_problem(f"jaw's {name}", array))
            if array.shape != shape:
                raise InputError(f"jaw's {name}: expected {shape}, found {array.shape}")
        if self.usual is not None and self.usual.middle.shape != (2 * COUNT,):
            raise InputError(f"jaw's usual shapes: expected {2 * COUNT} numbers, found {len(self.usual.middle)}")

    @classmethod
    def even(cls) -> "JawPlaces":
        """At equal distances, whatever the face."""
        return cls(np.zeros((2 * INNER, 2 * COUNT)), np.tile(EVENLY[1:-1], 2))

    def mark(self, points: np.ndarray) -> np.ndarray:
        """Landmarks (L, 2) with the jaw's points where people would mark them, on the same curve.

        Ears and chin stay where they are.
        """
        points = space_jaw(points)
        shape = face_shape(points)
        told = (self.weight @ shape + self.bias).reshape(2, INNER)
        inner = EVENLY[1:-1] + self._unusual(shape) * (told - EVENLY[1:-1])
        inner = np.sort(np.clip(inner, 0, 1), axis=1)
        return place_jaw(points, np.pad(inner, ((0, 0), (1, 1)), constant_values=((0, 0), (0, 1))))

    def _unusual(self, shape: np.ndarray) -> float:
        """From 0 to 1, how far a shape (136,) is not that of a usual face."""
        if self.usual is None:
            return 1.0
        return float(np.interp(self.usual.distances(shape[None])[0], _USUAL, (0, 1)))


def face_shape(points: np.ndarray) -> np.ndarray:
    """(136,) the first 68 landmarks (L, 2), turned until the eyes are level, about their mean, in their diagonal."""
    points = points[:COUNT]
    across, down = points[list(EYE_LEFT)].mean(0) - points[list(EYE_RIGHT)].mean(0)
    turn = np.array([[across, -down], [down, across]]) / max(np.hypot(across, down), np.finfo(float).tiny)
    upright = (points - points.mean(0)) @ turn
    return (upright / max(np.linalg.norm(np.ptp(upright, axis=0)), np.finfo(float).tiny)).ravel()
