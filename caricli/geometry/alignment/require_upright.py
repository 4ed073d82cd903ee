"""Whether a head stands as another does."""

import numpy as np

from caricli.errors import InputError

_TURNED = 30
"""Degrees beyond which a head is turned, and not only crooked."""


def require_upright(vertices: np.ndarray, upright: np.ndarray) -> None:
    """Raise InputError for a head that lies, looks aside, or is a mirror image.

    vertices, upright: (V, 3) of it and of one that looks to +z with +y up, in any units and places.
    """
    u, _, vt = np.linalg.svd((vertices - vertices.mean(0)).T @ (upright - upright.mean(0)))
    expected = "expected a head that looks to +z and has +y up and its left side at +x"
    if np.linalg.det(u @ vt) < 0:
        raise InputError(f"{expected}, found its mirror image")
    turned = np.degrees(np.arccos(np.clip((np.trace(u @ vt) - 1) / 2, -1, 1)))
    if turned > _TURNED:
        raise InputError(f"{expected}, found one turned by {turned:.0f} degrees")
