"""Irises and pupils among the strokes of a sketch, round lines in an eye, which are none of its lids; and the eyes."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from caricli.structures.sketch import Stroke

_ROUND = 1.5
"""How many times as wide as high an iris is, or as high as wide, at most: lids hide some of it."""
_OPEN = 0.45
"""Of its length: the ends of an iris are nearer to each other."""
_CLOSED = 0.2
"""The same of a line around an eye."""
_SLACK = 0.15
"""Of its size: how far an iris may lie beyond the line around its eye."""
_WIDER = (1.2, 6.0)
"""How many times as wide as an iris an eye is."""
_REACH = 1.2
"""Heights of an iris, from its middle to the lids, at most."""
_ALIKE = 2.0
"""How many times as large as one of a pair the other is, at most; also the widths of two lids."""


@dataclass(frozen=True, eq=False)
class _Box:
    """The box around a stroke. points: (N, 2) of it. gap: how far its ends are apart, as a share of its length. low,
    high: (2,) pixels."""

    points: np.ndarray
    gap: float
    low: np.ndarray
    high: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """(2,) pixels."""
        return (self.low + self.high) / 2

    @property
    def size(self) -> np.ndarray:
        """Width and height, pixels."""
        return self.high - self.low

    @property
    def is_round(self) -> bool:
        """Whether it may be an iris."""
        return bool(self.gap < _OPEN and self.size.min() > 0 and self.size.max() < _ROUND * self.size.min())

    def holds(self, other: "_Box") -> bool:
        """Whether another lies within, or nearly so."""
        slack = _SLACK * other.size
        return bool((other.low > self.low - slack).all() and (other.high < self.high + slack).all())

    def spans(self, other: "_Box") -> bool:
        """Whether the middle of another lies between its sides."""
        return bool(self.low[0] < other.middle[0] < self.high[0])

    def below(self, iris: "_Box") -> float:
        """How far below the middle of an iris it passes, in heights of the iris."""
        column = np.abs(self.points[:, 0] - iris.middle[0]).argmin()
        return float((self.points[column, 1] - iris.middle[1]) / iris.size[1])


def find_irises(strokes: Sequence[Stroke]) -> tuple[list[int], list[int]]:
    """Numbers of the strokes that draw irises or pupils: round ones within a closed line, or between two lines, of an
    eye, where the other eye has one, too, and what is drawn in these; and of the closed lines that are such eyes.

    strokes: of some length, pixels. What goes around, or over and under, the round lines of both sides is no eye: it is
    a face, or a nose with its nostrils; a round line without a second one beside it may be a mouth. Of several lines
    around an iris the nearest ones are the eye, the others glasses.
    """
    boxes = [_box(stroke) for stroke in strokes]
    eyes = [(box, several) for box in boxes if box.is_round and (several := _eyes(box, boxes))]
    irises: list[_Box] = []
    rings: list[_Box] = []
    for iris, own in eyes:
        if any(_is_pair(iris, other) and _is_apart(own, other) and _is_apart(others, iris) for other, others in eyes):
            irises.append(iris)
            nearest = min(own, key=lambda eye: max(line.size[0] for line in eye))
            rings += nearest if len(nearest) == 1 else ()
    within = [number for number, box in enumerate(boxes) if any(box is iris or iris.holds(box) for iris in irises)]
    around = [number for number, box in enumerate(boxes) if any(box is ring for ring in rings) and number not in within]
    return within, around


def _box(stroke: Stroke) -> _Box:
    points = stroke.points
    gap = float(np.linalg.norm(points[0] - points[-1])) / max(stroke.length, 1e-9)
    return _Box(points, gap, points.min(0), points.max(0))


def _is_pair(one: _Box, other: _Box) -> bool:
    """Whether two round lines may be the irises of two eyes: alike, and beside each other."""
    width = max(one.size[0], other.size[0])
    aside, below = np.abs(one.middle - other.middle)
    return bool(width < _ALIKE * min(one.size[0], other.size[0]) and aside > 1.5 * width and below < aside / 2)


def _is_apart(eyes: Sequence[tuple[_Box, ...]], other: _Box) -> bool:
    """Whether one of some eyes does not reach to the iris of the other."""
    return any(not any(line.spans(other) for line in eye) for eye in eyes)


def _eyes(iris: _Box, boxes: Sequence[_Box]) -> list[tuple[_Box, ...]]:
    """What may be an eye around an iris: closed lines, and pairs of one over it and one under it."""
    least, most = _WIDER
    lines = [box for box in boxes if least * iris.size[0] < box.size[0] < most * iris.size[0] and box.spans(iris)]
    near = [(line, below) for line in lines if abs(below := line.below(iris)) < _REACH]
    over = [line for line, below in near if below < 0]
    under = [line for line, below in near if below > 0]
    lids = [(a, b) for a, b in product(over, under) if max(a.size[0], b.size[0]) < _ALIKE * min(a.size[0], b.size[0])]
    return [*((line,) for line in lines if line.gap < _CLOSED and line.holds(iris)), *lids]
