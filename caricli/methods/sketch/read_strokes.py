"""What a network reads in the strokes of a sketch: where they change, and what they draw."""

from dataclasses import replace

import numpy as np

from caricli.geometry.lines.cut_line import cut_line
from caricli.methods.sketch.stroke_candidates import is_ring
from caricli.methods.sketch.stroke_runs import stroke_runs
from caricli.methods.sketch.strokes_read import StrokesRead
from caricli.models.strokes.model import StrokeModel
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

_LEAST = 1e-3
"""Chance of a curve at a place, at least: a place alone rules out none."""
_CHANGE = 10.0
"""What every change along a stroke costs, in logarithms of the chances of places. Of lines that run into each other on
paper a lower price cuts as many, and of a hand's strokes too many."""


def read_strokes(sketch: Sketch, network: StrokeModel) -> StrokesRead:
    """What the strokes of a sketch draw.

    Strokes change at the corners of an eye that is drawn in one, or where lines of several curves run into each other
    in a picture: along a stroke the likeliest curves of its places one after the other, of which every change has a
    price (Viterbi). Each stroke is read by itself, so that several may have one name. Strokes that have names keep
    them, and no other gets one of these; kinds stay, and wrinkles stay what they are.

    sketch: Sketch with lines. network: StrokeModel, whose names may be none of a head's. Raises InputError where
    nothing is drawn.
    """
    reading = network.read(sketch)
    taken = [stroke.curve for stroke in sketch.strokes]
    chances = np.where(np.isin(reading.curves, [name for name in taken if name]), 0.0, reading.chances)
    logs = np.log(np.maximum(np.hstack([1 - chances.sum(1, keepdims=True), chances]), _LEAST))
    names = (None, *reading.curves)
    strokes: list[Stroke] = []
    means: list[np.ndarray] = []
    for number, stroke in enumerate(sketch.strokes):
        rows = np.flatnonzero(reading.places.owner == number)
        if stroke.curve is not None or stroke.kind == StrokeKind.WRINKLE:
            strokes.append(stroke)
            means.append(chances[rows].mean(0))
            continue
        for piece, own in _pieces(stroke, logs[rows], reading.places.along[rows]):
            strokes.append(replace(piece, curve=names[_likeliest(logs[rows[own]])]))
            means.append(chances[rows[own]].mean(0))
    return StrokesRead(sketch.with_strokes(strokes), np.stack(means), reading.curves)


def _likeliest(logs: np.ndarray) -> int:
    """The class of places in a row. logs: (N, C) of the chances at them."""
    return int(logs.sum(0).argmax())


def _pieces(stroke: Stroke, logs: np.ndarray, along: np.ndarray) -> list[tuple[Stroke, np.ndarray]]:
    """The pieces of a stroke, and the numbers of their places. logs: (N, C) of the chances at the stroke's places.
    along: (N,) of these, shares of its length."""
    runs = [np.arange(*run) for run in stroke_runs(logs, _CHANGE)]
    if len(runs) == 1:
        return [(stroke, runs[0])]
    lines = cut_line(stroke.points, [along[run[0] - 1 : run[0] + 1].mean() for run in runs[1:]])
    if is_ring(stroke) and _likeliest(logs[runs[0]]) == _likeliest(logs[runs[-1]]):
        lines[0] = np.concatenate([lines.pop(), lines[0]])
        runs[0] = np.concatenate([runs.pop(), runs[0]])
    return [(stroke.moved_to(line), run) for line, run in zip(lines, runs, strict=True)]
