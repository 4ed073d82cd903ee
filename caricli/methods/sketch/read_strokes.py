"""What a network reads in the strokes of a sketch: where they change, and what they draw."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from caricli.geometry.lines.cut_line import cut_line
from caricli.methods.sketch.settings import MOUTH
from caricli.methods.sketch.stroke_candidates import LOOPS, is_ring
from caricli.methods.sketch.stroke_runs import stroke_runs
from caricli.methods.sketch.strokes_read import StrokesRead
from caricli.models.strokes.model import StrokeModel
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

_LEAST = 1e-3
"""Chance of a curve at a place, at least: a place alone rules out none."""
_CHANGE = 10.0
"""What every change along a stroke costs, in logarithms of the chances of places. Of lines that run into each other on
paper a lower price cuts as many, and of a hand's strokes too many."""


def read_strokes(sketch: Sketch, whole: Collection[int], network: StrokeModel) -> StrokesRead:
    """What the strokes of a sketch draw.

    Strokes change at the corners of an eye that is drawn in one, or where lines of several curves run into each other
    in a picture: along a stroke the likeliest curves of its places one after the other, of which every change has a
    price (Viterbi). Closed ones are cut only where they draw several curves, and lips only into both of a loop. Each
    stroke is read by itself, so that several may have one name. Strokes that have names keep them, and no other gets
    one of these; kinds stay, and wrinkles stay what they are.

    sketch: Sketch with lines. whole: numbers of strokes that are not cut, and get no name. network: StrokeModel, whose
    names may be none of a head's. Raises InputError where nothing is drawn, or the network tells no chances.
    """
    reading = network.read(sketch)
    taken = {stroke.curve for stroke in sketch.strokes}
    chances = np.where([name in taken for name in reading.curves], 0.0, reading.chances)
    logs = np.log(np.maximum(np.hstack([1 - chances.sum(1, keepdims=True), chances]), _LEAST))
    names = (None, *reading.curves)
    strokes: list[Stroke] = []
    means: list[np.ndarray] = []
    for number, stroke in enumerate(sketch.strokes):
        rows = np.flatnonzero(reading.places.owner == number)
        pieces = [(stroke, np.arange(len(rows)))]
        if number not in whole and stroke.curve is None and stroke.kind != StrokeKind.WRINKLE:
            pieces = _pieces(stroke, logs[rows], reading.places.along[rows], names)
        strokes += [piece for piece, _ in pieces]
        means += [chances[rows[own]].mean(0) for _, own in pieces]
    return StrokesRead(sketch.with_strokes(strokes), np.stack(means), reading.curves)


def _pieces(
    stroke: Stroke, logs: np.ndarray, along: np.ndarray, names: Sequence[str | None]
) -> list[tuple[Stroke, np.ndarray]]:
    """The pieces of a stroke with their names, and the numbers of their places. logs: (N, C) of the chances at the
    stroke's places. along: (N,) of these, shares of its length. names: C of the classes."""
    runs = [np.arange(*run) for run in stroke_runs(logs, _CHANGE)]
    curves = [names[int(logs[run].sum(0).argmax())] for run in runs]
    ring = is_ring(stroke)
    if len(runs) == 1 or (ring and not _follow_each_other(curves)):
        return [(replace(stroke, curve=names[int(logs.sum(0).argmax())]), np.arange(len(logs)))]
    lines = cut_line(stroke.points, [along[run[0] - 1 : run[0] + 1].mean() for run in runs[1:]], stroke.pressure)
    if ring and curves[0] == curves[-1]:
        lines[0] = np.concatenate([lines.pop(), lines[0]])
        runs[0] = np.concatenate([runs.pop(), runs[0]])
        curves.pop()
    pieces = [replace(_along(stroke, rows), curve=curve) for rows, curve in zip(lines, curves, strict=True)]
    return list(zip(pieces, runs, strict=True))


def _along(stroke: Stroke, rows: np.ndarray) -> Stroke:
    """A stroke along other points. rows: (N, 2), and a third column of its pressure where it has one."""
    return replace(stroke, points=rows[:, :2], pressure=None if stroke.pressure is None else rows[:, 2])


def _follow_each_other(curves: Sequence[str | None]) -> bool:
    """Whether people draw such curves in one closed stroke: several, of lips alone two that form a loop."""
    drawn = {curve for curve in curves if curve is not None}
    lips = all(curve.startswith(MOUTH) for curve in drawn)
    return any(drawn.issuperset(loop) for loop in LOOPS) if lips else len(drawn) > 1
