"""What a ``clip-path`` of an SVG leaves of lines."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError

_CHUNK = 2**18
"""Pairs of a piece of a line and an edge that are looked at together."""
_MOST_PAIRS = 2**27
"""Of a drawing."""

Shape = tuple[Sequence[np.ndarray], bool]
"""Outlines (N, 2), pixels, which are closed, and whether the even-odd rule says what lies inside."""


@dataclass
class Clipper:
    """Cuts lines, of a drawing some together. pairs: of pieces and edges that were looked at."""

    pairs: int = 0

    def cut(self, line: np.ndarray, clip: Sequence[Shape]) -> list[np.ndarray]:
        """The parts (M, 2) of a line (N, 2) that lie in any of a clip's shapes; the line itself where all of it does.

        Raises InputError where there is more to cut than a hand draws.
        """
        edges = [_edges(outlines) for outlines, _ in clip]
        count = sum(len(each) for each in edges)
        self.pairs += 2 * count * len(line)
        if self.pairs > _MOST_PAIRS:
            raise InputError("clip-path: expected fewer or simpler lines and outlines, found more than a hand draws")
        if not count:
            return []
        points = _crossed(line, np.concatenate(edges))
        middles = (points[1:] + points[:-1]) / 2 if len(points) > 1 else points
        inside = np.zeros(len(middles), bool)
        for each, (_, even_odd) in zip(edges, clip, strict=True):
            inside |= _is_inside(middles, each, even_odd)
        if inside.all():
            return [line]
        turns = np.flatnonzero(np.diff(np.r_[False, inside, False].astype(int)))
        return [points[start : end + 1] for start, end in turns.reshape(-1, 2)]


def _edges(outlines: Sequence[np.ndarray]) -> np.ndarray:
    """(M, 2, 2) both ends of the edges of closed outlines."""
    return np.concatenate(
        [np.zeros((0, 2, 2)), *(np.stack([outline, np.roll(outline, -1, axis=0)], axis=1) for outline in outlines)]
    )


def _crossed(line: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """A line (N, 2) with points of its own where it crosses edges (M, 2, 2)."""
    ways = np.diff(line, axis=0)
    along = edges[:, 1] - edges[:, 0]
    places = [np.arange(len(line), dtype=np.float64)]
    step = max(1, _CHUNK // len(edges))
    for start in range(0, len(ways), step):
        way = ways[start : start + step, None]
        apart = edges[None, :, 0] - line[start : start + step][: len(way), None]
        with np.errstate(all="ignore"):
            turn = _cross(way, along[None])
            on_line = _cross(apart, along[None]) / turn
            on_edge = _cross(apart, way) / turn
            rows, columns = np.nonzero((on_line > 0) & (on_line < 1) & (on_edge >= 0) & (on_edge <= 1))
        places.append(start + rows + on_line[rows, columns])
    place = np.unique(np.concatenate(places))
    first = np.minimum(place.astype(int), max(len(line) - 2, 0))
    return line[first] + (place - first)[:, None] * ways[first] if len(ways) else line


def _is_inside(points: np.ndarray, edges: np.ndarray, even_odd: bool) -> np.ndarray:
    """Which points (P, 2) lie within edges (M, 2, 2) of closed outlines."""
    inside = np.zeros(len(points), bool)
    step = max(1, _CHUNK // max(len(edges), 1))
    for start in range(0, len(points), step):
        x, y = points[start : start + step, None].transpose(2, 0, 1)
        (ax, ay), (bx, by) = edges[:, 0].T, edges[:, 1].T
        with np.errstate(all="ignore"):
            right = x < ax + (y - ay) / (by - ay) * (bx - ax)
        winding = np.where(right & ((ay <= y) != (by <= y)), np.sign(by - ay), 0).sum(1)
        inside[start : start + step] = winding % 2 != 0 if even_odd else winding != 0
    return inside


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
