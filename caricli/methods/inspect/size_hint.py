"""What a height says of the unit of a head."""

import numpy as np

HEAD_HEIGHT = (0.1, 1.0)
"""How high a head may be, metres."""

_USUAL_HEIGHT = 0.25
_UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254}


def size_hint(height: float) -> str | None:
    """What a height says of the unit, or None where it is that of a head in metres."""
    if HEAD_HEIGHT[0] <= height <= HEAD_HEIGHT[1]:
        return None
    metres = {unit: height * share for unit, share in _UNITS.items()}
    heads = {unit: high for unit, high in metres.items() if HEAD_HEIGHT[0] <= high <= HEAD_HEIGHT[1]}
    if heads:
        unit = min(heads, key=lambda unit: abs(np.log(heads[unit] / _USUAL_HEIGHT)))
        return f"{height:.3g} m high, as a head in {unit}: expected metres"
    return f"{height:.3g} m high: expected a head in metres, {HEAD_HEIGHT[0]} to {HEAD_HEIGHT[1]:g} m"
