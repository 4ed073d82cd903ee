"""A drawing of lines."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Self

import numpy as np

from caricli.limits import MAX_COORDINATE, MAX_SKETCH_POINTS, MAX_SKETCH_SIDE, MAX_STROKES
from caricli.structures.checks import number_problem, refuse, shape_problem

CANVAS = 256
"""Pixels, width and height of a canvas where nothing else is said: what the networks see."""

NAME_LENGTH = 64
"""Most letters of a curve's name."""


class StrokeKind(StrEnum):
    """What a stroke draws, section 3.1 of the sketch paper."""

    SILHOUETTE = "silhouette"
    FEATURE = "feature"
    WRINKLE = "wrinkle"
    UNKNOWN = "unknown"


CURVES: dict[str, StrokeKind] = {
    "silhouette": StrokeKind.SILHOUETTE,
    **dict.fromkeys(
        (
            *("brow_left", "brow_right", "eye_upper_left", "eye_upper_right", "eye_lower_left", "eye_lower_right"),
            *("nose", "nose_tip", "nose_bridge", "nostril_left", "nostril_right", "mouth_inner_upper"),
            *("mouth_inner_lower", "ear_left", "ear_right"),
        ),
        StrokeKind.FEATURE,
    ),
    # The outer contour of the lips counts as a wrinkle in figure 3 of the sketch paper; so does the fold of a lid here.
    **dict.fromkeys(("mouth_upper", "mouth_lower", "eye_fold_left", "eye_fold_right"), StrokeKind.WRINKLE),
}
"""Names of the curves of the bundled head, with the kinds of their strokes; left and right are the subject's."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """One line of a sketch.

    points: (N, 2) float64, pixels of the canvas, x right, y down, (0, 0) the centre of its top left pixel; a closed
    line ends where it begins, one dot is a single point. kind: StrokeKind. curve: name of the curve that it draws, as
    the annotation of a head has it, or None. pressure: (N,) from 0 to 1, or None where nothing is known of it. width:
    pixels, or None. Raises InputError when it is no line.
    """

    points: np.ndarray
    kind: StrokeKind = StrokeKind.UNKNOWN
    curve: str | None = None
    pressure: np.ndarray | None = None
    width: float | None = None

    def __post_init__(self) -> None:
        """Check that it is a line."""
        points = np.asarray(self.points, np.float64)
        refuse(shape_problem("points", points, (None, 2), MAX_COORDINATE))
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "kind", StrokeKind(self.kind))
        if self.curve is not None and not (0 < len(self.curve) <= NAME_LENGTH and self.curve.isprintable()):
            refuse(f"curve: expected a name of at most {NAME_LENGTH} letters, found another")
        if self.pressure is not None:
            pressure = np.asarray(self.pressure, np.float64)
            refuse(shape_problem("pressure", pressure, (len(points),), 1))
            if (pressure < 0).any():
                refuse("pressure: expected numbers from 0 to 1, found a negative one")
            object.__setattr__(self, "pressure", pressure)
        if self.width is not None:
            refuse(number_problem("width", np.asarray(self.width), MAX_SKETCH_SIDE))
            if self.width <= 0:
                refuse("width: expected more than 0 pixels, found less")

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
        return len(self.points) > 2 and bool((self.points[0] == self.points[-1]).all())

    @property
    def length(self) -> float:
        """Pixels along the line."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def moved(self, points: np.ndarray) -> Self:
        """The same stroke at other points (N, 2), as many as there are."""
        return replace(self, points=points)

    def moved_to(self, points: np.ndarray) -> Self:
        """The same stroke along other points (M, 2), without a pressure."""
        return replace(self, points=points, pressure=None)


@dataclass(frozen=True, eq=False)
class Sketch:
    """Lines on a canvas, in the order in which they were drawn.

    strokes: of Stroke; they may leave the canvas. size: (width, height) of the canvas, pixels.
    Raises InputError when there are too many or too long ones, or the canvas has no size.
    """

    strokes: tuple[Stroke, ...] = field(default_factory=tuple)
    size: tuple[int, int] = (CANVAS, CANVAS)

    def __post_init__(self) -> None:
        """Check that it can be drawn."""
        object.__setattr__(self, "strokes", tuple(self.strokes))
        if len(self.size) != 2 or not all(1 <= side <= MAX_SKETCH_SIDE for side in self.size):
            refuse(f"size: expected a canvas of 1 to {MAX_SKETCH_SIDE} pixels, found {self.size}")
        if len(self.strokes) > MAX_STROKES:
            refuse(f"strokes: expected at most {MAX_STROKES}, found {len(self.strokes)}")
        count = sum(len(stroke.points) for stroke in self.strokes)
        if count > MAX_SKETCH_POINTS:
            refuse(f"strokes: expected at most {MAX_SKETCH_POINTS} points together, found {count}")

    def with_strokes(self, strokes: Iterable[Stroke]) -> Self:
        """Other strokes on the same canvas."""
        return replace(self, strokes=tuple(strokes))

    def scaled(self, size: tuple[int, int]) -> Self:
        """The sketch on another canvas: centred in it, as large as fits. size: (width, height) pixels."""
        zoom = min(size[0] / self.size[0], size[1] / self.size[1])
        # Corners of pixels lie half a pixel before their centres.
        middle = (np.array(self.size) - 1) / 2
        there = (np.array(size) - 1) / 2
        strokes = [
            replace(
                stroke,
                points=(stroke.points - middle) * zoom + there,
                width=None if stroke.width is None else stroke.width * zoom,
            )
            for stroke in self.strokes
        ]
        return replace(self, strokes=tuple(strokes), size=(int(size[0]), int(size[1])))
