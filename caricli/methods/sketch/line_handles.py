"""The vertices of a head that lines are drawn of, and where a sketch wants them."""

from collections.abc import Mapping, Sequence

import numpy as np

from caricli.geometry.match_line import match_line, resample
from caricli.methods.sketch.settings import CORNERED
from caricli.structures.sketch import Sketch
from caricli.template.feature_curves import FeatureCurve

_SAMPLES = 24
"""Points of a line by which its direction is told."""
_GAP = 0.1
"""Of a line's length: ends of a closed line may be so far apart."""
_SHORTEST = 1e-3
"""Of the canvas: what is shorter is a dot."""


class LineHandles:
    """The vertices of all curves of a head, each once.

    curves: FeatureCurves. vertices: (H,) ids.
    """

    def __init__(self, curves: tuple[FeatureCurve, ...]) -> None:
        """curves: of a template, see ``feature_curves``."""
        self.curves = curves
        self.vertices = np.unique(np.concatenate([curve.vertices for curve in curves]))
        self.rows = {curve.name: np.searchsorted(self.vertices, curve.vertices) for curve in curves}

    def rows_of(self, start: str) -> np.ndarray:
        """(N,) handles of the curves whose names begin so."""
        rows = [rows for name, rows in self.rows.items() if name.startswith(start)]
        return np.unique(np.concatenate(rows)) if rows else np.zeros(0, int)

    def places(self, drawn: Mapping[str, Sequence[np.ndarray]], own: np.ndarray) -> np.ndarray:
        """Where lines want the handles: on the lines that were drawn for their curves.

        A handle that several lines want gets their mean: so two strokes over the same stretch count as one between
        them, and a curve drawn in pieces keeps its gaps.

        drawn: lines (N, 2) by the names of curves, in any direction, of some length. own: (H, 2) where the handles are.
        Returns (H, 2), NaN where nothing was drawn.
        """
        sums = np.zeros((len(own), 2))
        counts = np.zeros(len(own))
        for curve in self.curves:
            lines = drawn.get(curve.name, ())
            for line in lines:
                rows = self.rows[curve.name]
                places = _match(curve, own[rows], line, alone=len(lines) == 1)
                met = np.isfinite(places).all(axis=1)
                np.add.at(sums, rows[met], places[met])
                np.add.at(counts, rows[met], 1)
        with np.errstate(invalid="ignore"):
            return sums / counts[:, None]


def lines_by_curve(sketch: Sketch) -> dict[str, list[np.ndarray]]:
    """Lines (N, 2) of a sketch by the curves that its strokes name; dots are none."""
    least = _SHORTEST * max(sketch.size)
    drawn: dict[str, list[np.ndarray]] = {}
    for stroke in sketch.strokes:
        if stroke.curve is not None and stroke.length > least:
            drawn.setdefault(stroke.curve, []).append(stroke.points)
    return drawn


def _match(curve: FeatureCurve, own: np.ndarray, line: np.ndarray, alone: bool) -> np.ndarray:
    """(K, 2) places of a curve's points own (K, 2) along a line, NaN for those beyond its ends. alone: whether no other
    line was drawn for it."""
    if not curve.closed:
        whole = alone and curve.name.startswith(CORNERED)
        return match_line(own, _same_way(own, line), whole)
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    if np.linalg.norm(line[0] - line[-1]) < _GAP * length:
        ring = _ring_from(own, line)
        return match_line(own, ring, whole=True)
    # Open it where nothing was drawn: opposite of the middle of the line.
    ring = own[:-1]
    nearest = _nearest(ring, resample(line, _SAMPLES))
    middle = nearest[len(nearest) // 2]
    shift = (middle + len(ring) // 2) % len(ring)
    order = np.roll(np.arange(len(ring)), -shift)
    places = np.full((len(own), 2), np.nan)
    places[order] = match_line(ring[order], _same_way(ring[order], line), whole=False)
    places[-1] = places[0]
    return places


def _nearest(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(N,) of the points the numbers that are nearest to those of a line (N, 2)."""
    return np.argmin(((points - line[:, None]) ** 2).sum(-1), axis=1)


def _same_way(own: np.ndarray, line: np.ndarray) -> np.ndarray:
    """A line in the direction of points own (K, 2)."""
    dense = resample(own, 4 * _SAMPLES)
    ways = [resample(way, _SAMPLES) for way in (line, line[::-1])]
    # Pieces are told by where they lie, all else by how they would meet.
    trend = np.sign(np.diff(_nearest(dense, ways[0]))).sum()
    ends = resample(own, _SAMPLES)
    centred = ends - ends.mean(0)
    along = (centred * (ways[0] - ways[0].mean(0))).sum() - (centred * (ways[1] - ways[1].mean(0))).sum()
    backwards = trend < 0 if abs(trend) > _SAMPLES // 2 else along < 0
    return line[::-1] if backwards else line


def _ring_from(own: np.ndarray, line: np.ndarray) -> np.ndarray:
    """A closed line in the direction of a closed curve own (K, 2), from where this begins."""
    ring = line if (line[0] == line[-1]).all() else np.concatenate([line, line[:1]])
    if _area(ring) * _area(own) < 0:
        ring = ring[::-1]
    dense = resample(ring, 16 * _SAMPLES)[:-1]
    low = own.min(0)
    size = np.maximum(np.ptp(own, axis=0), 1e-9)
    start = dense.min(0) + (own[0] - low) / size * np.ptp(dense, axis=0)
    first = int(_nearest(dense, start[None])[0])
    turned = np.roll(dense, -first, axis=0)
    return np.concatenate([turned, turned[:1]])


def _area(ring: np.ndarray) -> float:
    """Twice the signed area within a closed line (N, 2)."""
    a, b = ring[:-1], ring[1:]
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
