"""How a part that moves keeps clear of walls, by a few smooth changes of its way."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

ROUNDS = 40
"""Times that rooms are asked, at most."""

START = 0.1
"""Of their least, what bounded amounts are first: where bounds are met the solver's steps are too small to go on."""


class Room(Protocol):
    """What has walls."""

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from the walls, negative where they are in them, and unit ways (N, 3) out."""


@dataclass(frozen=True, eq=False)
class Bends:
    """Changes of the way of N points.

    moves: (N, 3, M), of an amount of one metre. hold: (M,) weights against amounts, to one point that is as deep. low:
    (M,) metres, the least that amounts may be, -inf for those that are free; the others are not above zero. wish: (M,)
    metres, what amounts are where nothing is in the way. start: (M,) metres, what free amounts are first, None for
    nothing.
    """

    moves: np.ndarray
    hold: np.ndarray
    low: np.ndarray
    wish: np.ndarray
    start: np.ndarray | None = None


def clear_way(
    rooms: Mapping[float, Room],
    points: np.ndarray,
    way: np.ndarray,
    bends: Bends,
    margin: float,
    least: np.ndarray | float = np.inf,
) -> tuple[np.ndarray, float]:
    """Amounts of changes that keep points clear of walls on the straight way from where they are.

    Minimises ``sum max(margin - distance, 0)^2 + sum (hold (amount - wish))^2`` over all points and rooms, with
    amounts within bounds.

    rooms: by shares of the way. points: (N, 3) at its beginning. way: (N, 3) metres. margin: metres from the walls.
    least: (N,) metres, what points keep that have not so much at its beginning.
    Returns (M,) metres, and what the worst point lacks of its margin, metres.
    """

    def lacks(amounts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        changed = way + bends.moves @ amounts
        rows = []
        for share, room in rooms.items():
            distance, out = room.room(points + share * changed)
            lack = np.maximum(np.minimum(margin, least) - distance, 0.0)
            rows.append((lack, -share * np.einsum("nc,ncm->nm", np.where(lack[:, None] > 0, out, 0.0), bends.moves)))
        held = [bends.hold * (amounts - bends.wish)], [np.diag(bends.hold)]
        values, slopes = (
            np.concatenate([*own, *more]) for own, more in zip(zip(*rows, strict=True), held, strict=True)
        )
        return values / margin, slopes / margin

    last = [bends.wish, *lacks(bends.wish)]
    if not last[1].any():
        return bends.wish, 0.0
    # Imported here: it takes longer than most heads need, which move nothing.
    from scipy.optimize import least_squares

    bounded = np.isfinite(bends.low)

    def asked(amounts: np.ndarray) -> list[np.ndarray]:
        # The solver asks for values and slopes one after the other.
        if not np.array_equal(last[0], amounts):
            last[:] = [amounts.copy(), *lacks(amounts)]
        return last

    result = least_squares(
        lambda amounts: asked(amounts)[1],
        # Not as is wished: bent far, points begin behind a wall, and the nearest way out is to its wrong side.
        np.where(bounded, START * bends.low, 0.0 if bends.start is None else bends.start),
        jac=lambda amounts: asked(amounts)[2],
        bounds=(bends.low, np.where(bounded, 0.0, np.inf)),
        x_scale=10 * margin,
        ftol=1e-4,
        xtol=1e-5,
        max_nfev=ROUNDS,
    )
    return result.x, float(margin * result.fun[: len(rooms) * len(points)].max())
