"""What a rig offers to an engine's face tracking, and how sound it is."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.deformation_gradients import DeformationGradients
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.structures import Rig
from caricli.structures.arkit import ARKIT_NAMES

_MOVED = 1e-6
"""Metres: a vertex that moves less stays."""

_SIMILAR = 0.9
"""Ratio of matching letters from which on a name is taken for a slip of the pen."""

_PLAIN = {name.lower(): name for name in ARKIT_NAMES}


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
    """The ARKit name that a name means, or None.

    Case, spaces and other separators, a prefix such as ``blendShape1.``, and the suffixes L and R are seen through, and
    so is a slip of the pen.
    """
    if name in ARKIT_NAMES:
        return name
    side = re.sub(r"(?<=[a-z])(?:L|R)$|[\W_]+[lLrR]$", lambda m: {"l": "Left", "r": "Right"}[m[0][-1].lower()], name)
    plain = re.sub(r"[\W_]+", "", re.split(r"[.:|]", side)[-1]).lower()
    close = [plain] if plain in _PLAIN else get_close_matches(plain, _PLAIN, 1, _SIMILAR)
    return _PLAIN[close[0]] if close else None


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
