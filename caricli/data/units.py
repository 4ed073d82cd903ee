"""The unit that meshes of heads are in, told by how high they are."""

from collections.abc import Sequence

import numpy as np

from caricli.errors import InputError

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001}
"""Metres of each."""

LOWEST = 0.1
HIGHEST = 0.8
"""Metres: heads with or without neck and shoulders, caricatures among them, are between these. Ten times as much is
more than the highest, nearly, so that the unit is never in doubt."""


def measured_unit(heights: Sequence[float]) -> str:
    """The unit, of UNITS, in which the usual one of heights is that of a head.

    heights: vertical extents of meshes. Raises InputError where it is in none.
    """
    usual = float(np.median(heights))
    for unit, metres in UNITS.items():
        if LOWEST <= usual * metres < HIGHEST:
            return unit
    raise InputError(
        f"expected heads of {LOWEST:g} to {HIGHEST:g} m, found them {usual:.3g} high, which is none in "
        f"{', '.join(UNITS)}; say which with --unit"
    )
