"""The inside of a mouth, and how a part is brought into it."""

from collections.abc import Mapping
from dataclasses import dataclass

import igl
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.structures.arkit import uses
from caricli.template.template import Template

STILL = 2e-4
"""Of the head's height: a wall that an expression moves less is still."""


_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class RoomSettings:
    """How parts make room for the wall of the mouth.

    margin: share of the head's height that they keep from it. rounds: moves, at most. hold: weight against a move, to
    one point that is pushed as far. shrink: the same against a change of size by the whole. smallest: of a part's size,
    what shrinking leaves. touch: how often its margin a tongue on its way out may be in the skin.
    """

    margin: float = 0.003
    rounds: int = 8
    hold: float = 0.03
    shrink: float = 0.3
    smallest: float = 0.4
    touch: float = 3.0


class Bag:
    """A part of the skin that is open like a bag, closed over its rim."""

    def __init__(self, template: Template, member: np.ndarray) -> None:
        """member: (V,) whether vertices belong to it."""
        faces = template.faces[member[template.faces].all(1)]
        self.ids, local = np.unique(faces, return_inverse=True)
        self.faces = local.reshape(-1, 3).astype(np.int64)
        edges = igl.boundary_facets(self.faces)[0]
        self.rim = np.unique(edges)
        fan = np.column_stack([edges[:, ::-1], np.full(len(edges), len(self.ids))])
        # Its skin faces into it: turned over, the winding number is one inside.
        self.closed = np.concatenate([self.faces, fan])[:, ::-1].copy()

    def holds(self, skin: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(N,) whether points (N, 3) are in it. skin: (W, 3) of its vertices."""
        closed = np.concatenate([skin, skin[self.rim].mean(0, keepdims=True)])
        return igl.fast_winding_number(closed, self.closed, np.ascontiguousarray(points)) > 0.5


class Pocket:
    """The wall of a mouth, closed behind the lips, and the same with the lips, closed before them."""

    def __init__(self, template: Template, wall: np.ndarray) -> None:
        """wall: vertex ids of the region that lines the mouth."""
        member = np.zeros(len(template.vertices), bool)
        member[wall] = True
        self.inner = Bag(template, member)
        self.ids = self.inner.ids
        member[template.annotation.regions.get("mouth", wall)] = True
        self.lips = Bag(template, member)
        self.inside = np.searchsorted(self.lips.ids, self.ids)
        self.height = template.height
        self.spread = spread(np.asarray(template.vertices, float)[self.ids])


class Mouths:
    """The mouth of a face in all its expressions.

    height: metres, of a usual head that has a mouth as large: what margins are shares of.
    """

    def __init__(self, pocket: Pocket, neutral: np.ndarray, names: tuple[str, ...], deltas: np.ndarray) -> None:
        """neutral: (V, 3) metres. names: K. deltas: (K, V, 3) metres."""
        self.pocket = pocket
        self.names = names
        self.neutral = neutral[pocket.lips.ids]
        self.deltas = deltas[:, pocket.lips.ids]
        self.uses = uses(names)
        self.rest = Mouth(pocket, self.neutral)
        self.height = pocket.height * spread(self.neutral[pocket.inside]) / pocket.spread
        # Expressions that others start from come first.
        self.order = np.argsort(self.uses.sum(1), kind="stable")
        self._mouths: dict[tuple[int, float, bool], Mouth] = {}

    def still(self, k: int) -> bool:
        """Whether expression k leaves the wall as it is."""
        return bool(np.abs(self.deltas[k, self.pocket.inside]).max(initial=0) < STILL * self.height)

    def mouth(self, k: int, amount: float, open_lips: bool = False) -> "Mouth":
        """With expression k, and what it starts from, at a weight; all parts look at the same one.

        open_lips: whether parts may come out.
        """
        if (k, amount, open_lips) not in self._mouths:
            skin = self.neutral + amount * np.tensordot(self.uses[k], self.deltas, 1)
            self._mouths[k, amount, open_lips] = Mouth(self.pocket, skin, open_lips)
        return self._mouths[k, amount, open_lips]


class Mouth:
    """A Pocket in the shape of one face."""

    def __init__(self, pocket: Pocket, skin: np.ndarray, open_lips: bool = False) -> None:
        """skin: (W, 3) metres, of the wall and the lips. open_lips: whether before the lips is in it, too."""
        self.pocket = pocket
        self.skin = skin
        self.open_lips = open_lips
        self.wall = skin if open_lips else skin[pocket.inside]
        self.faces = pocket.lips.faces if open_lips else pocket.inner.faces
        self.tree = igl.AABB()
        self.tree.init(self.wall, self.faces)
        self.normals = triangle_normals(self.wall, self.faces)

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from the wall, negative outside, and unit ways (N, 3) into the mouth."""
        points = np.ascontiguousarray(points)
        squared, face, nearest = self.tree.squared_distance(self.wall, self.faces, points)
        distance = np.sqrt(squared)
        away = points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, winding numbers decide: behind
        # the lips may still be in a lip that crosses the other one.
        outside = (self.normals[face] * away).sum(1) < 0
        if outside.any():
            doubtful = points[outside]
            in_mouth = np.ones(len(doubtful), bool)
            if not self.open_lips:
                in_mouth = self.pocket.inner.holds(self.wall, doubtful)
            if in_mouth.any():
                in_mouth[in_mouth] = self.pocket.lips.holds(self.skin, doubtful[in_mouth])
            outside[outside] = ~in_mouth
        sign = np.where(outside, -1.0, 1.0)
        return sign * distance, sign[:, None] * away / np.maximum(distance, 1e-9)[:, None]

    def pushes(self, points: np.ndarray, margin: float) -> np.ndarray:
        """(N, 3) the way of points (N, 3) into the mouth, zero for those that are, margin metres from its wall."""
        distance, ways = self.room(points)
        return np.maximum(margin - distance, 0)[:, None] * ways


def make_room(
    mouth: Mouth,
    points: np.ndarray,
    margin: float,
    scaling: bool = True,
    settings: RoomSettings = RoomSettings(),  # noqa: B008 (frozen)
) -> tuple[float, np.ndarray]:
    """A scale and a move that bring points into a mouth, as little as can be.

    Every round minimises ``sum |change of the point along its push - push|^2`` with weights against moves and changes
    of size; what was pushed before holds its ground while others are.

    points: (N, 3) of a part. margin: metres that they keep from the wall. scaling: whether the size may change.
    Returns s and t (3,): points go to ``centre + s (points - centre) + t``, with the centre their mean.
    """
    centre = points.mean(0)
    away = points - centre
    size = np.sqrt((away**2).sum(1).mean())
    damping = np.diag([settings.hold] * 3 + [settings.shrink * size**2])
    free = slice(0, 4 if scaling else 3)
    scale = 1.0
    shift = np.zeros(3)
    touched = np.zeros(len(points), bool)
    ways = np.zeros_like(points)
    for _ in range(settings.rounds):
        push = mouth.pushes(centre + scale * away + shift, margin)
        length = np.linalg.norm(push, axis=1)
        pushed = length > 0
        if not pushed.any():
            break
        ways[pushed] = push[pushed] / length[pushed, None]
        touched |= pushed
        rows = np.column_stack([ways, (ways * away).sum(1)])[touched][:, free]
        step = np.linalg.solve(rows.T @ rows + damping[free, free], rows.T @ length[touched])
        shift = shift + step[:3]
        if scaling:
            scale = float(np.clip(scale + step[3], settings.smallest, 1.0))
    return scale, shift


def bend_out(
    mouths: Mapping[float, Mouth],
    points: np.ndarray,
    way: np.ndarray,
    margin: float,
    settings: RoomSettings = RoomSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """What is to be added to a tongue's way out (N, 3), so that it comes between the lips.

    Its back is raised, which leaves the tip where it goes; where that does not do, all of it is raised and flattened.
    All by smooth functions of how far its points go and how high they are, for points that are pressed one by one
    crumple; where the lips leave no way it stays in them.

    mouths: with open lips, by weights of the expression. points: (N, 3) at rest. way: (N, 3) at weight 1. margin:
    metres that they keep from the skin.
    """
    share = np.linalg.norm(way, axis=1)
    share = share / share.max()
    above = (points + way)[:, 1]
    above = above - share @ above / share.sum()
    thickness = np.abs(above).max()

    def raised(basis: np.ndarray, flattest: float) -> tuple[np.ndarray, float]:
        amounts = np.zeros(basis.shape[1])
        for _ in range(2 * settings.rounds):
            damped = settings.hold * np.eye(len(amounts))
            asked = np.zeros(len(amounts))
            deepest = 0.0
            for weight, mouth in mouths.items():
                push = mouth.pushes(points + weight * (way + np.outer(basis @ amounts, _UP)), margin)
                length = np.linalg.norm(push, axis=1)
                deepest = max(deepest, length.max())
                rows = weight * (push @ _UP / np.maximum(length, 1e-12))[:, None] * basis
                damped = damped + rows.T @ rows
                asked = asked + rows.T @ length
            if deepest <= settings.touch * margin:
                break
            amounts += np.linalg.solve(damped, asked)
            amounts[-1] = max(amounts[-1], flattest)
        return np.outer(basis @ amounts, _UP), deepest

    bent, deepest = raised((share * (1 - share))[:, None], 0.0)
    if deepest <= settings.touch * margin:
        return bent
    return raised(np.stack([share, share**2, share * above / thickness], -1), (settings.smallest - 1) * thickness)[0]


def spread(points: np.ndarray) -> float:
    """How far points (N, 3) are from their mean, as the root of the mean square."""
    return float(np.sqrt(((points - points.mean(0)) ** 2).sum(1).mean()))
