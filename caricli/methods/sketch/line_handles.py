"""The vertices of a head that lines are drawn of, and where a sketch wants them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from caricli.methods.sketch.match_curve import match_curve
from caricli.structures.sketch import Sketch
from caricli.template.feature_curves import FeatureCurve

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

    def rows_of(self, start: str | tuple[str, ...]) -> np.ndarray:
        """(N,) handles of the curves whose names begin so, or in one of several ways."""
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
                places = match_curve(curve, own[rows], line, alone=len(lines) == 1)
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


def with_own_names(sketch: Sketch, handles: LineHandles) -> Sketch:
    """A sketch without the names that a head has no curve of."""
    rows = handles.rows
    return sketch.with_strokes(s if s.curve in rows else replace(s, curve=None) for s in sketch.strokes)
