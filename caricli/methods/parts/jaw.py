"""The bone of the jaw."""

from collections.abc import Sequence

import numpy as np

from caricli.geometry.alignment.weighted_similarities import weighted_similarities
from caricli.structures import Part
from caricli.template.template import Template

RIGID = 0.002
"""Of the head's height: skin that moves so much otherwise than the bone says half as much of it."""

STILL = 1e-4
"""Metres: what an expression of the template moves less it leaves where it is."""


class Jaw:
    """The motion of the jaw's bone, read from the skin that moves with it."""

    def __init__(self, template: Template, part: Part, actions: np.ndarray) -> None:
        """part: that hangs on the jaw and is rigid, with its expressions. actions: (K, V, 3) metres, what the same
        expressions do to the skin."""
        start = np.asarray(part.mesh.vertices, float)
        vertices = np.asarray(template.vertices, float)
        self.names = part.names
        self.anchors: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        if not len(self.names):
            ids = template.region("jaw")
            self.shared = (ids, np.ones(len(ids)))
            return
        self.moving = np.abs(np.asarray(part.deltas)).max((1, 2)) > STILL
        _, turns, shifts = weighted_similarities(start, start + part.deltas, np.ones(len(start)), scaling=False)
        with_bone = vertices @ np.swapaxes(turns, -1, -2) + shifts[:, None] - vertices
        apart = np.linalg.norm(actions - with_bone, axis=-1) / (RIGID * template.height)
        moving = np.linalg.norm(with_bone, axis=-1) / (RIGID * template.height)
        # What hardly moves with the bone, near the joint, must not outweigh the chin because it is hardly apart.
        own = 1 / (1 + apart**4) * np.minimum(moving, 1)
        shared = 1 / (1 + apart.max(0) ** 2) ** 2 * np.minimum(moving.max(0), 1)
        self.anchors = {name: _largest(own[k]) for k, name in enumerate(self.names) if self.moving[k]}
        self.usual = {name: (turns[k], shifts[k]) for k, name in enumerate(self.names)}
        self.shared = _largest(shared)

    def moves(self, name: str) -> bool:
        """Whether an expression of the template moves the bone."""
        return name in self.anchors

    def motion(self, actions: Sequence[str], neutral: np.ndarray, delta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (3, 3) and translation (3,) of the bone of a face (V, 3) in an expression (V, 3).

        actions: names of what the expression is made of.
        """
        moving = [name for name in actions if self.moves(name) or name not in self.names]
        if not moving:
            return np.eye(3), np.zeros(3)
        ids, weights = self.anchors.get(moving[0], self.shared) if len(moving) == 1 else self.shared
        start = neutral[ids]
        _, turn, shift = weighted_similarities(start, start + delta[ids], weights, scaling=False)
        return turn, shift


def _largest(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ids of the vertices that count, and their weights."""
    ids = np.flatnonzero(weights > 1e-2 * weights.max())
    return ids, weights[ids]
