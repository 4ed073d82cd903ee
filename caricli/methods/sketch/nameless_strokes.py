"""The strokes of a sketch whose curves are to be found, and what is known of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.methods.sketch.find_irises import find_irises
from caricli.methods.sketch.mirrored_strokes import mirrored_strokes
from caricli.methods.sketch.stroke_candidates import StrokeShapes
from caricli.methods.sketch.strokes_read import Read, StrokesRead
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

_MOST = 256
"""Strokes that are looked at, the longest."""
_SHORTEST = 0.01
"""Of the canvas, or twice a smaller drawing in it: what is shorter draws no curve."""
_CHANCES = (1e-2, 0.14)
"""Of a curve: the least that counts, and one that speaks neither for it nor against it."""


@dataclass(frozen=True, eq=False)
class NamelessStrokes:
    """A sketch, its irises and pupils wrinkles: lids would be looked for in them.

    numbers: of the strokes that may draw a curve which they do not name. eyes: (S,) bool, which of these go around an
    iris, however large. told: Sketch with the names that a network reads, too. read: StrokesRead of it, or None.
    """

    sketch: Sketch
    numbers: list[int]
    eyes: np.ndarray
    told: Sketch
    read: StrokesRead | None

    @classmethod
    def of(cls, sketch: Sketch, read: Read | None = None) -> "NamelessStrokes":
        """Those of a sketch, cut as a network reads them, but for irises and the lines around them."""
        numbers = _longest(sketch)
        irises, around = ([numbers[k] for k in found] for found in find_irises([sketch.strokes[n] for n in numbers]))
        plain = sketch.with_strokes(
            replace(stroke, kind=StrokeKind.WRINKLE) if number in irises else stroke
            for number, stroke in enumerate(sketch.strokes)
        )
        strokes_read = read(plain, around) if read is not None and _longest(plain) else None
        told = plain if strokes_read is None else strokes_read.sketch
        given = {stroke.curve for stroke in sketch.strokes}
        cut = told.with_strokes(s if s.curve in given else replace(s, curve=None) for s in told.strokes)
        left = _longest(cut)
        eyes = {sketch.strokes[number].points.tobytes() for number in around}
        is_eye = np.array([cut.strokes[number].points.tobytes() in eyes for number in left], bool)
        return cls(cut, left, is_eye, told, strokes_read)

    @cached_property
    def strokes(self) -> list[Stroke]:
        """The strokes of these numbers."""
        return [self.sketch.strokes[number] for number in self.numbers]

    @cached_property
    def shapes(self) -> StrokeShapes:
        """How these run."""
        return StrokeShapes.of(self.strokes)

    @cached_property
    def mirrored(self) -> np.ndarray:
        """(S,) bool, which of these have another one on the other side, as ``mirrored_strokes`` tells it."""
        return mirrored_strokes(self.strokes)

    @property
    def most_likely(self) -> float:
        """What ``surprise`` is at least, over all strokes: of names that a network is sure of; 0 without one."""
        return 0.0 if self.read is None else len(self.numbers) * float(np.log(_CHANCES[1]))

    def surprise(self, candidates: Sequence[tuple[str, ...]]) -> np.ndarray:
        """(S, C) by how much it speaks against each stroke drawing one of the curves of a candidate that a network
        finds it unlikely, in logarithms of chances; below 0 where it is likely, 0 without a network, or for curves that
        it knows nothing of.

        candidates: C names of one or several curves.
        """
        if self.read is None:
            return np.zeros((len(self.numbers), len(candidates)))
        draws = np.array([[name in names for name in self.read.curves] for names in candidates])
        chances = self.read.chances[self.numbers] @ draws.T
        least, neither = _CHANCES
        return np.where(draws.any(1), -np.log(np.maximum(chances, least) / neither), 0.0)


def rejoined(named: Sketch, sketch: Sketch) -> Sketch:
    """A named sketch whose pieces are in one again where those that follow each other draw the same. sketch: before it
    was cut."""
    whole = {stroke.points.tobytes() for stroke in sketch.strokes}
    strokes = list(named.strokes[:1])
    for stroke in named.strokes[1:]:
        last = strokes[-1]
        cut = not whole.intersection((last.points.tobytes(), stroke.points.tobytes()))
        if cut and last.curve == stroke.curve and last.points[-1].tobytes() == stroke.points[0].tobytes():
            strokes[-1] = _continued(last, stroke)
        else:
            strokes.append(stroke)
    return named.with_strokes(strokes)


def _continued(stroke: Stroke, other: Stroke) -> Stroke:
    """A stroke that goes on along another one, which begins where it ends."""
    points = np.concatenate([stroke.points, other.points[1:]])
    if stroke.pressure is None or other.pressure is None:
        return stroke.moved_to(points)
    return replace(stroke, points=points, pressure=np.concatenate([stroke.pressure, other.pressure[1:]]))


def _longest(sketch: Sketch) -> list[int]:
    """Numbers of the strokes that may draw a curve which they do not name, the longest ones."""
    drawn = np.concatenate([np.zeros((0, 2)), *(stroke.points for stroke in sketch.strokes)])
    least = _SHORTEST * min(max(sketch.size), 2 * float(np.ptp(drawn, axis=0).max())) if len(drawn) else 0.0
    lengths = {
        number: stroke.length
        for number, stroke in enumerate(sketch.strokes)
        if stroke.curve is None and stroke.kind != StrokeKind.WRINKLE and stroke.length > least
    }
    return sorted(sorted(lengths, key=lambda number: -lengths[number])[:_MOST])
