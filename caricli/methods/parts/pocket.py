"""The inside of a mouth."""

from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.parts.flesh import Flesh, Hide
from caricli.structures.arkit import uses
from caricli.template.template import Template

RIM = 0.016
"""Of the head's height: how far from the wall the rims of lips go, which roll in over teeth."""

ROUNDED = 1e-9
"""Metres: what is nearer to where it was pushed is there."""


class Pocket:
    """The wall of a mouth, closed behind the lips; the same with their rims, and with all of them."""

    def __init__(self, template: Template, wall: np.ndarray) -> None:
        """wall: vertex ids of the region that lines the mouth."""
        vertices = np.asarray(template.vertices, float)
        lips = template.annotation.regions.get("mouth", wall)
        near = KDTree(vertices[wall]).query(vertices[lips])[0] <= RIM * template.height
        self.inner = _bag(template, [wall])
        self.ids = self.inner.ids
        self.rimmed = _bag(template, [wall, lips[near]])
        self.lips = _bag(template, [wall, lips])
        self.to_rim = np.searchsorted(self.lips.ids, self.rimmed.ids)
        corners = self.rimmed.ids[self.rimmed.faces]
        self.rims = np.unique(self.rimmed.faces[~np.isin(corners, self.ids).all(1)])
        self.inside = np.searchsorted(self.lips.ids, self.ids)
        self.height = template.height
        self.spread = spread(vertices[self.ids])


class Mouths:
    """The mouth of a face in all its expressions.

    height: metres, of a usual head that has a mouth as large: what margins are shares of.
    """

    def __init__(self, pocket: Pocket, neutral: np.ndarray, names: tuple[str, ...], deltas: np.ndarray) -> None:
        """neutral: (V, 3) metres. names: K. deltas: (K, V, 3) metres."""
        self.pocket = pocket
        self.names = names
        self.neutral = neutral[pocket.lips.ids]
        self.uses = uses(names)
        self.changes = np.tensordot(self.uses, deltas[:, pocket.lips.ids], 1)
        self.rest = Mouth(pocket, self.neutral)
        self.height = pocket.height * spread(self.neutral[pocket.inside]) / pocket.spread
        # Expressions that others start from come first.
        self.order = np.argsort(self.uses.sum(1), kind="stable")
        self._mouths: dict[tuple[int, float], Mouth] = {}

    def moves(self, k: int) -> float:
        """Metres, how far expression k, with what it starts from, moves the wall at most."""
        return float(np.linalg.norm(self.changes[k, self.pocket.inside], axis=1).max())

    def mouth(self, k: int, amount: float) -> "Mouth":
        """With expression k, and what it starts from, at a weight; all parts look at the same one."""
        if (k, amount) not in self._mouths:
            self._mouths[k, amount] = Mouth(self.pocket, self.neutral + amount * self.changes[k])
        return self._mouths[k, amount]


class Mouth:
    """A Pocket in the shape of one face."""

    def __init__(self, pocket: Pocket, skin: np.ndarray) -> None:
        """skin: (W, 3) metres, of the wall and the lips."""
        self.pocket = pocket
        self.inner = Flesh(pocket.inner, skin[pocket.inside])
        self.lips = Flesh(pocket.lips, skin)
        self.rimmed = Flesh(pocket.rimmed, skin[pocket.to_rim])

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from the wall, negative outside, and unit ways (N, 3) into the mouth."""
        squared, face, nearest = self.inner.nearest(points)
        distance = np.sqrt(squared)
        away = points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, winding numbers decide: behind
        # the lips may still be in a lip that crosses the other one.
        outside = self.inner.ahead(points, face, nearest) < 0
        if outside.any():
            doubtful = points[outside]
            in_mouth = self.inner.holds(doubtful)
            if in_mouth.any():
                in_mouth[in_mouth] = self.lips.holds(doubtful[in_mouth])
            outside[outside] = ~in_mouth
        sign = np.where(outside, -1.0, 1.0)
        return sign * distance, sign[:, None] * away / np.maximum(distance, 1e-9)[:, None]

    def pushes(self, points: np.ndarray, margin: np.ndarray | float) -> np.ndarray:
        """(N, 3) the way of points (N, 3) into the mouth, zero for those that are, margin metres from its wall.

        What keeps so far from the wall may still be in the rim of a lip that rolls in: it goes the way out of that.
        """
        distance, ways = self.room(points)
        pushes = np.maximum(margin - distance, 0)[:, None] * ways
        # What was pushed so far stands there but for rounding, which must not tell what becomes of it.
        clear = distance > margin + ROUNDED
        low, high = self._rims
        aside = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
        # Before the wall itself is what has that nearer than all rims.
        asked = clear & ((distance <= 0) | (aside <= distance))
        pushes[asked] = self._out_of_rims(points[asked])
        return pushes

    @cached_property
    def _rims(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest (3,) and highest (3,) coordinates of the rims of the lips, metres; infinitely far without any."""
        rims = self.rimmed.skin[self.pocket.rims]
        return rims.min(0, initial=np.inf), rims.max(0, initial=-np.inf)

    def _out_of_rims(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) the way out of lips' rims, zero for points (N, 3) that are in none."""
        _, face, nearest = self.rimmed.nearest(points)
        ways = nearest - points
        within = self.rimmed.ahead(points, face, nearest) < 0
        # The side of the nearest face is mostly right; where it says within, the winding number decides.
        if within.any():
            within[within] = ~self.lips.holds(points[within])
        return np.where(within[:, None], ways, 0.0)


def _bag(template: Template, regions: list[np.ndarray]) -> Hide:
    """The part of the skin that regions of vertex ids cover: open like a bag, and its skin faces into it."""
    member = np.zeros(len(template.vertices), bool)
    member[np.concatenate(regions)] = True
    return Hide(template.faces[member[template.faces].all(1)], inwards=True)


def spread(points: np.ndarray) -> float:
    """How far points (N, 3) are from their mean, as the root of the mean square."""
    return float(np.sqrt(((points - points.mean(0)) ** 2).sum(1).mean()))
