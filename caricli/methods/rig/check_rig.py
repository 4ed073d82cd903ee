"""What a rig offers to an engine's face tracking, and how sound it is."""

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.structures import Rig
from caricli.structures.arkit import ARKIT_NAMES, arkit_name, plain_name

_MOVED = 1e-6
"""Metres: a vertex that moves less stays."""

_SIMILAR = 0.9
"""Ratio of matching letters from which on a name is taken for a slip of the pen."""


@dataclass(frozen=True)
class ShapeCheck:
    """One shape at full weight.

    largest: metres, largest displacement.
    moved: vertices moved by more than a micrometre.
    flipped: share of triangles turned over, in [0, 1], or None where it cannot be told.
    """

    name: str
    largest: float
    moved: int
    flipped: float | None

    @property
    def empty(self) -> bool:
        """Whether it moves nothing."""
        return self.moved == 0


@dataclass(frozen=True)
class RigCheck:
    """What was found.

    exact: names in ARKit's spelling.
    near: other names, and the spelling that they are near.
    unknown: names near none.
    missing: ARKit's names that are neither there nor near.
    shapes: ShapeCheck of every shape in the rig's order.
    """

    exact: tuple[str, ...]
    near: dict[str, str]
    unknown: tuple[str, ...]
    missing: tuple[str, ...]
    shapes: tuple[ShapeCheck, ...]


def check_rig(rig: Rig) -> RigCheck:
    """Compare a rig with what ARKit's face tracking drives, and look at every shape."""
    near = {name: arkit for name in rig.names if (arkit := nearest_arkit(name)) and arkit != name}
    exact = tuple(name for name in rig.names if name in ARKIT_NAMES)
    covered = {*exact, *near.values()}
    return RigCheck(
        exact=exact,
        near=near,
        unknown=tuple(name for name in rig.names if name not in near and name not in exact),
        missing=tuple(name for name in ARKIT_NAMES if name not in covered),
        shapes=tuple(_shape_checks(rig)),
    )


def nearest_arkit(name: str) -> str | None:
    """The ARKit name that a name means, as ``arkit_name`` has it or but for a slip of the pen, or None."""
    if exact := arkit_name(name):
        return exact
    close = get_close_matches(plain_name(name), [each.lower() for each in ARKIT_NAMES], 1, _SIMILAR)
    return arkit_name(close[0]) if close else None


def _shape_checks(rig: Rig) -> Iterator[ShapeCheck]:
    neutral = np.asarray(rig.neutral, np.float64)
    try:
        gradients = DeformationGradients(neutral, rig.faces)
    except NumericsError:
        # Triangles without area have no side to turn over, and nothing around them tells.
        gradients = None
    for name, delta in zip(rig.names, rig.deltas, strict=True):
        length = np.linalg.norm(np.asarray(delta, np.float64), axis=1)
        flipped = None if gradients is None else float(flipped_triangles(neutral + delta, gradients).mean())
        yield ShapeCheck(name, float(length.max()), int((length > _MOVED).sum()), flipped)
