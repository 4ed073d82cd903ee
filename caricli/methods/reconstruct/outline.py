"""Landmarks beyond the 68 that were found in a picture; whoever finds them, the fits take them so."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.structures.landmarks import COUNT, EAR_LEFT, EAR_RIGHT, EXTRA_NAMES, OUTLINE
from caricli.template.template import Template

SIDES = {"right": EAR_RIGHT, "left": EAR_LEFT}
"""The landmarks of an ear: top, outer, lobe."""


_SURE = 0.1
"""Mean confidence from which on an ear that was found says something beside what a detector saw."""

_DEVIATION = 0.025
"""Of such an ear's landmarks, along each axis, as a share of the landmarks' diagonal."""

_FARTHEST = 10.0
"""Mean squared distance of an ear's landmarks from detected ones, in their common covariances, from which on what was
found is another thing."""

_SMALLEST = 80.0
"""Pixels, of the diagonal of detected landmarks, below which a picture is too coarse to know better."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Further landmarks that were found in a picture.

    points: (13, 2) pixels, those beyond iBUG-68, NaN where nothing was found. confidence: (13,) from 0, where nothing
    was found, to 1, as sure as a landmark that was marked by hand.
    """

    points: np.ndarray
    confidence: np.ndarray

    @property
    def found(self) -> bool:
        """Whether there is any."""
        return bool((self.confidence > 0).any())

    @property
    def sure_ears(self) -> "Outline":
        """The ears alone that say something beside detected ones."""
        confidence = np.zeros(len(self.points))
        for numbers in SIDES.values():
            rows = np.array(numbers) - COUNT
            if self.confidence[rows].mean() >= _SURE:
                confidence[rows] = self.confidence[rows]
        return Outline(np.where(confidence[:, None] > 0, self.points, np.nan), confidence)

    def after(self, points: np.ndarray) -> np.ndarray:
        """(81, 2) landmarks (68, 2), and after them those that were found, NaN where nothing was."""
        return np.concatenate([points, np.where(self.confidence[:, None] > 0, self.points, np.nan)])

    def joined(self, points: np.ndarray, spreads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Detected landmarks (81, 2) and their covariances (81, 2, 2) with what was found: each counts as it is sure.

        Of two places with covariances S and T the mean by S^-1 and T^-1 is taken, whose covariance is (S^-1 + T^-1)^-1.
        An ear that is too far from the detected one says nothing.
        """
        deviation = np.eye(2) * (_DEVIATION * _extent(points)) ** 2
        moved = np.array(points)
        doubts = np.array(spreads)
        for numbers in SIDES.values():
            rows = np.array(numbers)
            places = self.points[rows - COUNT]
            seen = np.isfinite(points[rows]).all(1)
            gaps = (places - points[rows])[seen]
            inverse = np.linalg.inv(spreads[rows][seen] + deviation)
            apart = np.einsum("ka,kab,kb->k", gaps, inverse, gaps)
            if (self.confidence[rows - COUNT] > 0).all() and (not seen.any() or apart.mean() < _FARTHEST):
                pulls = np.zeros((len(rows), 2, 2))
                pulls[seen] = np.linalg.inv(spreads[rows][seen])
                own = np.linalg.inv(pulls + np.linalg.inv(deviation))
                shares = own @ pulls
                moved[rows] = places - np.einsum("kab,kb->ka", shares, places - np.nan_to_num(points[rows]))
                doubts[rows] = own
        return moved, doubts

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        rows = zip(EXTRA_NAMES, self.points, self.confidence, strict=True)
        return {name: {"point": point, "confidence": float(sure)} for name, point, sure in rows if sure > 0}


def can_find_outline(points: np.ndarray, template: Template, spreads: np.ndarray | None = None) -> bool:
    """Whether there is anything to find: further landmarks that were not given, on a head that has them.

    points: (L, 2) pixels, NaN where unknown. spreads: (L, 2, 2) covariances of their errors, or None; what has some was
    not marked by hand, and may be surpassed.
    """
    note = template.annotation
    curves = (f"ear_{side}" for side in SIDES)
    return (
        (len(points) == COUNT or spreads is not None)
        and note.has_extra
        and all(len(note.curves.get(name, ())) > 2 for name in curves)
        and bool(np.isfinite(points[list(OUTLINE)]).all())
        and (len(points) == COUNT or _extent(points) >= _SMALLEST)
    )


def _extent(points: np.ndarray) -> float:
    """Diagonal of the known ones of the first 68 landmarks, pixels."""
    first = points[:COUNT]
    return float(np.linalg.norm(np.ptp(first[np.isfinite(first).all(1)], axis=0)))
