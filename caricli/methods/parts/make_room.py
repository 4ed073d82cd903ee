"""How a part makes room for the wall of the mouth: moved, turned and shrunk as a whole, and a little bent."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.parts.clear_way import Room

_WHOLE = 7
"""Moves of the part as a whole: three shifts, three turns, a change of size. The others are bends."""


@dataclass(frozen=True)
class RoomSettings:
    """How parts make room for the wall of the mouth.

    margin: share of the head's height that they keep from it. rounds: times that the mouth is asked, at most. hold:
    weight against moves of all points, to one point that lacks as much. bent: how much more bends weigh. enough: share
    of the margin; steps that are shorter are the last.
    """

    margin: float = 0.0015
    rounds: int = 15
    hold: float = 0.5
    bent: float = 0.5
    enough: float = 0.03


YIELDING = (0, 1, 2, 10)
"""Of `room_moves`, what expressions may call for: shifts, and a back of the arch that is narrower, x by x z."""


def room_moves(shape: np.ndarray, firm: np.ndarray) -> np.ndarray:
    """What a part can do to make room, (W, M, 3): moves of its points, of amounts of a metre.

    Bends are shifts by the squares of where a point is across and in depth: what stands on the arch goes along as it
    is, since they do not ask how high it is.

    shape: (W, 3) metres, +x across, +z in depth. firm: ids of points that make room.
    """
    away = shape - shape[firm].mean(0)
    x, y, z = (away / np.sqrt((away[firm] ** 2).sum(1).mean())).T
    nought = np.zeros_like(x)
    turns = [[nought, -z, y], [z, nought, -x], [-y, x, nought]]
    whole = [*turns, [x, y, z]]
    moves = np.array(whole).transpose(2, 0, 1)
    grown = np.array([np.ones_like(x), x**2, x * z, z**2])
    shifts = np.einsum("kw,ij->wkij", grown, np.eye(3)).reshape(len(shape), -1, 3)
    return np.concatenate([shifts[:, :3], moves, shifts[:, 3:]], axis=1)


def make_room(
    mouth: Room,
    points: np.ndarray,
    moves: np.ndarray,
    margin: float,
    settings: RoomSettings = RoomSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """Amounts of moves that bring points into a mouth, as little as can be.

    Minimises ``sum max(margin - distance, 0)^2 + hold mean |change of a point|^2``, with bends counted more.

    points: (N, 3) of a part. moves: (N, M, 3), the first seven of the part as a whole. margin: metres that points keep
    from the wall. Returns (M,) metres.
    """
    flat = moves.transpose(0, 2, 1).reshape(-1, moves.shape[1])
    cost = settings.hold / len(points) * flat.T @ flat
    more = np.where(np.arange(len(cost)) < _WHOLE, 0.0, settings.bent) * np.diag(cost)
    cost += np.diag(more + 1e-3 * np.diag(cost).mean())
    amounts = np.zeros(len(cost))
    for _ in range(settings.rounds):
        distance, ways = mouth.room(points + moves.transpose(0, 2, 1) @ amounts)
        if (distance >= margin).all():
            break
        slopes = np.einsum("nmc,nc->nm", moves, ways)
        change = _least(slopes, margin - distance + slopes @ amounts, cost, amounts) - amounts
        amounts = amounts + change
        if np.abs(flat @ change).max() < settings.enough * margin:
            break
    return amounts


def _least(slopes: np.ndarray, lacks: np.ndarray, cost: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Amounts (M,) that minimise ``sum max(lacks - slopes amounts, 0)^2 + amounts cost amounts``.

    slopes: (N, M). lacks: (N,) metres. cost: (M, M). start: (M,) near them.
    """
    amounts = start
    active = np.zeros(len(lacks), bool)
    for _ in range(6):
        lacking = lacks - slopes @ amounts > 0
        if (lacking == active).all():
            break
        active = lacking
        rows = slopes[active]
        amounts = np.linalg.solve(rows.T @ rows + cost, rows.T @ lacks[active])
    return amounts
