"""What rows of teeth leave of the way out of a mouth."""

from collections.abc import Sequence

import numpy as np

from caricli.methods.parts.clear_way import Room
from caricli.structures import Material, Part

_COLUMNS = 32
"""Across a row of teeth, in each of which its end and its depth are told."""

_AROUND = 0.08
"""Of its width: so far before and behind a row nothing may be beyond its end, for surfaces go on between points."""


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
