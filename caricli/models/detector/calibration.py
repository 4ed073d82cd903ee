"""What is known of a detector's network once it is trained."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from caricli.errors import InputError, shown
from caricli.models.detector.jaw_places import JawPlaces

TRUST = (0.01, 100.0)
"""Of what doubts are multiplied by, the least and the most."""

FARTHEST = 0.5
"""Pixels of the window that regions are shifted by, at most."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """By what a network's answers are corrected.

    trust: what its doubts are multiplied by. jaw: JawPlaces, where the jaw's points are marked. shift: pixels of the
    window, right and down: the pixel j of its regions lies at 2 j and this.
    """

    trust: float = 1.0
    jaw: JawPlaces = field(default_factory=JawPlaces.even)
    shift: tuple[float, float] = (0.0, 0.0)


def calibration_of(metadata: Mapping[str, Any], jaw: JawPlaces | None) -> Calibration:
    """The Calibration of a detector's file. jaw: None for equal distances.

    Raises InputError for a trust or a shift that none may have.
    """
    trust = metadata.get("trust")
    if not isinstance(trust, float) or not TRUST[0] <= trust <= TRUST[1]:
        raise InputError(f"expected a trust from {TRUST[0]:g} to {TRUST[1]:g}, found {shown(trust, 60)!r}")
    # Detectors of before do not tell it.
    shift = metadata.get("shift", [0.0, 0.0])
    if not isinstance(shift, list) or len(shift) != 2 or not all(map(_is_shift, shift)):
        raise InputError(f"expected a shift of two numbers up to {FARTHEST:g}, found {shown(shift, 60)!r}")
    return Calibration(trust, JawPlaces.even() if jaw is None else jaw, (shift[0], shift[1]))


def _is_shift(value: Any) -> bool:
    return isinstance(value, float) and abs(value) <= FARTHEST
