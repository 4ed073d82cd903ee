"""Whether a head stands as another does."""

import numpy as np

from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity

_TURNED = 30
"""Degrees beyond which a head is turned, and not only crooked."""


def require_upright(vertices: np.ndarray, upright: np.ndarray) -> None:
    """Raise InputError for a head that lies, looks aside, or is a mirror image.

    vertices, upright: (V, 3) of it and of one that looks to +z with +y up, in any units and places.
    """
    _, rotation, _ = similarity(upright, vertices)
    expected = "expected a head that looks to +z and has +y up and its left side at +x"
    # What fits best is a reflection.
    if np.linalg.det((vertices - vertices.mean(0)).T @ (upright - upright.mean(0))) < 0:
        raise InputError(f"{expected}, found its mirror image")
    turned = np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))
    if turned > _TURNED:
        raise InputError(f"{expected}, found one turned by {turned:.0f} degrees")
