"""Landmarks beyond the 68 that were found in a picture; whoever finds them, the fits take them so."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.structures.landmarks import COUNT, EAR_LEFT, EAR_RIGHT, EXTRA_NAMES, OUTLINE
from caricli.template.template import Template

SIDES = {"right": EAR_RIGHT, "left": EAR_LEFT}
"""The landmarks of an ear: top, outer, lobe."""


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

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        rows = zip(EXTRA_NAMES, self.points, self.confidence, strict=True)
        return {name: {"point": point, "confidence": float(sure)} for name, point, sure in rows if sure > 0}


def can_find_outline(points: np.ndarray, template: Template) -> bool:
    """Whether there is anything to find: further landmarks that were not given, on a head that has them.

    points: (L, 2) pixels, NaN where unknown.
    """
    note = template.annotation
    curves = (f"ear_{side}" for side in SIDES)
    return (
        len(points) == COUNT
        and note.has_extra
        and all(len(note.curves.get(name, ())) > 2 for name in curves)
        and bool(np.isfinite(points[list(OUTLINE)]).all())
    )
