"""What a stroke of a sketch may draw, and how well it does."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.distance import cdist

from caricli.geometry.lines.match_line import resample
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.settings import NamingSettings
from caricli.structures.sketch import Stroke, StrokeKind

LOOPS = (
    ("eye_upper_left", "eye_lower_left"),
    ("eye_upper_right", "eye_lower_right"),
    ("mouth_upper", "mouth_lower"),
    ("mouth_inner_upper", "mouth_inner_lower"),
)
"""Curves from corner to corner that are drawn in one closed stroke, too."""

_POINTS = (32, 64)
"""Of a stroke, and of a curve, that are compared."""
_GAP = 0.2
"""Of a stroke's length: its ends are nearer to each other in a closed one."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """What a stroke may draw: one curve, or two that form a loop.

    names: of the curves. kind: StrokeKind. line: (N, 2) pixels, points at equal distances along it.
    """

    names: tuple[str, ...]
    kind: StrokeKind
    line: np.ndarray

    @property
    def loop(self) -> bool:
        """Whether it is of two curves."""
        return len(self.names) > 1


def candidates_at(handles: LineHandles, own: np.ndarray) -> list[Candidate]:
    """What there is to draw of a face. own: (H, 2) pixels of its handles."""
    lines = {curve.name: own[handles.rows[curve.name]] for curve in handles.curves}
    single = [Candidate((curve.name,), curve.kind, resample(lines[curve.name], _POINTS[1])) for curve in handles.curves]
    rings = [
        Candidate(names, StrokeKind.FEATURE, resample(np.concatenate([lines[names[0]], lines[names[1]][::-1]]), 64))
        for names in LOOPS
        if set(names) <= set(lines)
    ]
    return single + rings


def is_ring(stroke: Stroke) -> bool:
    """Whether it ends about where it begins."""
    return bool(np.linalg.norm(stroke.points[0] - stroke.points[-1]) < _GAP * stroke.length)


@dataclass(frozen=True, eq=False)
class StrokeShapes:
    """How strokes run, whatever they are compared with.

    kinds: S StrokeKind. lines: (S, 32, 2) pixels, points at equal distances along each. directions: (S, 32, 2), unit
    vectors there. lengths: (S,) pixels. rings: (S,) bool, see ``is_ring``.
    """

    kinds: tuple[StrokeKind, ...]
    lines: np.ndarray
    directions: np.ndarray
    lengths: np.ndarray
    rings: np.ndarray

    @classmethod
    def of(cls, strokes: Sequence[Stroke]) -> "StrokeShapes":
        """Those of strokes, each of some length."""
        lines = np.array([resample(stroke.points, _POINTS[0]) for stroke in strokes]).reshape(-1, _POINTS[0], 2)
        lengths = np.array([stroke.length for stroke in strokes])
        rings = np.array([is_ring(stroke) for stroke in strokes], bool)
        return cls(tuple(stroke.kind for stroke in strokes), lines, _directions(lines), lengths, rings)

    def may_draw(self, candidates: Sequence[Candidate]) -> np.ndarray:
        """(S, C) bool: whether strokes are of the kind of candidates, and closed where these are."""
        silhouettes = np.array([each.kind == StrokeKind.SILHOUETTE for each in candidates], bool)
        loops = np.array([each.loop for each in candidates], bool)
        kinds = np.array([kind == StrokeKind.SILHOUETTE for kind in self.kinds], bool)[:, None] == silhouettes
        kinds |= np.array([kind == StrokeKind.UNKNOWN for kind in self.kinds], bool)[:, None]
        return kinds & (self.rings[:, None] | ~loops)


@dataclass(frozen=True, eq=False)
class StrokeCosts:
    """How far strokes are from what they may draw, in shares of a face's diagonal; infinite where they cannot.

    whole: (S, C) of strokes that draw all of it. part: (S, C) of strokes that may draw a part. nearest: (S, C, 32) of
    the points along the stroke the numbers of the nearest ones of the curve.
    """

    whole: np.ndarray
    part: np.ndarray
    nearest: np.ndarray


def stroke_costs(
    shapes: StrokeShapes, candidates: Sequence[Candidate], unit: float, settings: NamingSettings
) -> StrokeCosts:
    """Compare strokes with candidates. shapes: StrokeShapes. unit: pixels, diagonal of the face."""
    shape = (len(shapes.kinds), len(candidates))
    whole = np.full(shape, np.inf)
    part = np.full(shape, np.inf)
    nearest = np.zeros((*shape, _POINTS[0]), int)
    curves = np.array([candidate.line for candidate in candidates])
    lengths = np.linalg.norm(np.diff(curves, axis=1), axis=-1).sum(1)
    along = _directions(curves)
    may_draw = shapes.may_draw(candidates)
    for s, line in enumerate(shapes.lines):
        gaps = cdist(line, curves.reshape(-1, 2)).reshape(len(line), *curves.shape[:2]).swapaxes(0, 1) / unit
        nearest[s] = gaps.argmin(2)
        there = np.take_along_axis(along, nearest[s][..., None], 1)
        turned = 1 - np.abs((shapes.directions[s] * there).sum(-1)).mean(1)
        near = gaps.min(2).mean(1) + settings.turn * turned
        back = np.minimum(gaps.min(1), settings.missing).mean(1)
        met = np.take_along_axis(curves, nearest[s][..., None], 1)
        apart = line - met
        unlike = np.linalg.norm(apart - apart.mean(1, keepdims=True), axis=-1).mean(1) / unit
        fits = may_draw[s]
        part[s, fits] = near[fits]
        fits = fits & (shapes.lengths[s] > settings.scrap * lengths)
        whole[s, fits] = (near + settings.back * back + settings.shape * unlike)[fits]
    return StrokeCosts(whole, part, nearest)


def split_ring(stroke: Stroke, candidate: Candidate) -> list[Stroke]:
    """The two strokes of a closed one that is a loop of two curves, corner to corner.

    The corners are the ends of the stroke along the line between those of the curves.
    """
    count = len(candidate.line) // 2
    upper, lower = candidate.line[:count], candidate.line[count:]
    axis = upper[-1] - upper[0]
    ring = resample(np.concatenate([stroke.points, stroke.points[:1]]), 257)[:-1]
    first, last = sorted((int((ring @ axis).argmin()), int((ring @ axis).argmax())))
    halves = [ring[first : last + 1], np.concatenate([ring[last:], ring[: first + 1]])]
    down = lower.mean(0) - upper.mean(0)
    halves.sort(key=lambda half: float(half.mean(0) @ down))
    return [
        replace(stroke, points=half, kind=candidate.kind, curve=name, pressure=None)
        for name, half in zip(candidate.names, halves, strict=True)
    ]


def _directions(lines: np.ndarray) -> np.ndarray:
    """Unit vectors along lines (..., N, 2), at their points."""
    along = np.gradient(lines, axis=-2)
    return along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-12)
