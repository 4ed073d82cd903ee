"""The inside of a mouth, and how a part is brought into it."""

from dataclasses import dataclass

import igl
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.structures.arkit import uses
from caricli.template.template import Template

STILL = 2e-4
"""Of the head's height: a wall that an expression moves less is still."""


@dataclass(frozen=True)
class RoomSettings:
    """How parts make room for the wall of the mouth.

    margin: share of the head's height that they keep from it. rounds: moves, at most. hold: weight against a move, to
    one point that is pushed as far. shrink: the same against a change of size by the whole. smallest: of a part's size,
    what shrinking leaves.
    """

    margin: float = 0.003
    rounds: int = 8
    hold: float = 0.03
    shrink: float = 0.3
    smallest: float = 0.4


class Pocket:
    """The wall of a mouth, closed where the lips are."""

    def __init__(self, template: Template, wall: np.ndarray) -> None:
        """wall: vertex ids of the region that lines the mouth."""
        member = np.zeros(len(template.vertices), bool)
        member[wall] = True
        faces = template.faces[member[template.faces].all(1)]
        self.ids, local = np.unique(faces, return_inverse=True)
        self.wall = local.reshape(-1, 3).astype(np.int64)
        edges = igl.boundary_facets(self.wall)[0]
        self.rim = np.unique(edges)
        fan = np.column_stack([edges[:, ::-1], np.full(len(edges), len(self.ids))])
        # The skin of a pocket faces into it: turned over, the winding number is one inside.
        self.closed = np.concatenate([self.wall, fan])[:, ::-1].copy()
        self.height = template.height
        self.spread = _spread(np.asarray(template.vertices, float)[self.ids])


class Mouths:
    """The mouth of a face in all its expressions.

    height: metres, of a usual head that has a mouth as large: what margins are shares of.
    """

    def __init__(self, pocket: Pocket, neutral: np.ndarray, names: tuple[str, ...], deltas: np.ndarray) -> None:
        """neutral: (V, 3) metres. names: K. deltas: (K, V, 3) metres."""
        self.pocket = pocket
        self.names = names
        self.neutral = neutral[pocket.ids]
        self.deltas = deltas[:, pocket.ids]
        self.uses = uses(names)
        self.rest = Mouth(pocket, self.neutral)
        self.height = pocket.height * _spread(self.neutral) / pocket.spread
        # Expressions that others start from come first.
        self.order = np.argsort(self.uses.sum(1), kind="stable")
        self._mouths: dict[tuple[int, float], Mouth] = {}

    def still(self, k: int) -> bool:
        """Whether expression k leaves the wall as it is."""
        return bool(np.abs(self.deltas[k]).max(initial=0) < STILL * self.height)

    def mouth(self, k: int, amount: float) -> "Mouth":
        """With expression k, and what it starts from, at a weight; all parts look at the same one."""
        if (k, amount) not in self._mouths:
            wall = self.neutral + amount * np.tensordot(self.uses[k], self.deltas, 1)
            self._mouths[k, amount] = Mouth(self.pocket, wall)
        return self._mouths[k, amount]


class Mouth:
    """A Pocket in the shape of one face."""

    def __init__(self, pocket: Pocket, wall: np.ndarray) -> None:
        """wall: (W, 3) metres."""
        self.pocket = pocket
        self.wall = wall
        self.tree = igl.AABB()
        self.tree.init(wall, pocket.wall)
        self.normals = triangle_normals(wall, pocket.wall)
        self.closed = np.concatenate([wall, wall[pocket.rim].mean(0, keepdims=True)])

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from the wall, negative outside, and unit ways (N, 3) into the mouth."""
        points = np.ascontiguousarray(points)
        squared, face, nearest = self.tree.squared_distance(self.wall, self.pocket.wall, points)
        distance = np.sqrt(squared)
        away = points - nearest
        # The side of the nearest face is quick and mostly right; where it says outside, the winding number decides.
        outside = (self.normals[face] * away).sum(1) < 0
        if outside.any():
            outside[outside] = igl.fast_winding_number(self.closed, self.pocket.closed, points[outside]) < 0.5
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


def _spread(points: np.ndarray) -> float:
    return float(np.sqrt(((points - points.mean(0)) ** 2).sum(1).mean()))
