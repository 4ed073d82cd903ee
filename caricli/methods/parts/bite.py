"""What rows of teeth leave of the way out of a mouth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from caricli.methods.parts.clear_way import Bends, Room, clear_way
from caricli.structures import Material, Part

_COLUMNS = 32
"""Across a row of teeth, in each of which its end and its depth are told."""

_AROUND = 0.08
"""Of its width: so far before and behind a row nothing may be beyond its end, for surfaces go on between points."""

SHARES = (1.0, 0.75, 0.5, 0.25)
"""Of what keeps a tongue clear of the teeth: as much as the lips leave it room for."""

YIELD = 3.0
"""Times its margin, what the worst point of a tongue may lack of that from lips to which teeth push it."""


@dataclass(frozen=True, eq=False)
class WayOut:
    """The way of a tongue out of a mouth.

    walls: the lips and what is around them, by shares of the way. points: (N, 3) metres, at its beginning. way: (N, 3)
    metres. bends: Bends of it. margin: metres from the walls.
    """

    walls: Mapping[float, Room]
    points: np.ndarray
    way: np.ndarray
    bends: Bends
    margin: float

    def clear(self) -> tuple[np.ndarray, float]:
        """Amounts of bends by which it is clear of the walls, and what its worst point lacks, as of ``clear_way``."""
        return clear_way(self.walls, self.points, self.way, self.bends, self.margin)

    def between(self, rows: Sequence[tuple[np.ndarray, int]], amounts: np.ndarray, lack: float) -> np.ndarray:
        """Amounts by which it is clear of teeth, too, at its end, before which they hardly part.

        Where there is no room for both it keeps clear of the lips, and of the teeth as far as it can.
        rows: of teeth, as of ``Bite``. amounts, lack: of ``clear``.
        """
        if not rows:
            return amounts
        end = max(self.walls)
        rooms = {**self.walls, end: Bite(self.walls[end], rows)}
        more = clear_way(rooms, self.points, self.way, self.bends, self.margin)[0] - amounts
        free = [share for share in SHARES if self._lack(amounts + share * more) <= max(lack, YIELD * self.margin)]
        return amounts + max(free, default=0.0) * more

    def _lack(self, amounts: np.ndarray) -> float:
        """Metres that its worst point lacks of its margin."""
        way = self.way + self.bends.moves @ amounts
        distances = (room.room(self.points + share * way)[0].min() for share, room in self.walls.items())
        return self.margin - min(distances)


class Bite:
    """Walls, and what is between rows of teeth, whose ends are as far up or down as what passes them may be."""

    def __init__(self, walls: Room, rows: Sequence[tuple[np.ndarray, int]]) -> None:
        """rows: points (N, 3) of each, metres, +y up, +z out of the mouth; 1 for one that stands up, -1 down."""
        self.walls = walls
        self.rows = [_Row(points, outwards) for points, outwards in rows]

    def room(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) from what is nearest, negative in it, and unit ways (N, 3) out."""
        distance, out = self.walls.room(points)
        for row in self.rows:
            above = row.room(points)
            nearer = above < distance
            distance = np.where(nearer, above, distance)
            out = np.where(nearer[:, None], [0.0, row.outwards, 0.0], out)
        return distance, out


class _Row:
    """The end of a row of teeth and how deep they stand, column by column."""

    def __init__(self, points: np.ndarray, outwards: int) -> None:
        self.outwards = outwards
        self.left, right = points[:, 0].min(), points[:, 0].max()
        self.width = (right - self.left) / _COLUMNS or 1.0
        self.end = np.full(_COLUMNS, -np.inf)
        self.back = np.full(_COLUMNS, np.inf)
        self.front = np.full(_COLUMNS, -np.inf)
        column = self._column(points).clip(0, _COLUMNS - 1)
        around = _AROUND * (right - self.left)
        np.maximum.at(self.end, column, outwards * points[:, 1])
        np.minimum.at(self.back, column, points[:, 2] - around)
        np.maximum.at(self.front, column, points[:, 2] + around)

    def room(self, points: np.ndarray) -> np.ndarray:
        """(N,) metres beyond the end of the teeth that points (N, 3) are above or below, inf where there are none."""
        column = self._column(points)
        inside = (column >= 0) & (column < _COLUMNS)
        column = np.where(inside, column, 0)
        inside &= (points[:, 2] > self.back[column]) & (points[:, 2] < self.front[column])
        return np.where(inside, self.outwards * points[:, 1] - self.end[column], np.inf)

    def _column(self, points: np.ndarray) -> np.ndarray:
        return np.floor((points[:, 0] - self.left) / self.width).astype(int)


def rows_of_teeth(parts: Sequence[Part], k: int) -> list[tuple[np.ndarray, int]]:
    """The points of the teeth among parts in their expression k, and which way they stand, for ``Bite``."""
    rows = []
    for part in parts:
        ids = np.unique(part.mesh.polygons[part.materials == Material.TEETH])
        ids = ids[ids >= 0]
        if len(ids):
            rows.append((part.mesh.vertices[ids] + part.deltas[k, ids], 1 if part.hangs_on == "jaw" else -1))
    return rows
