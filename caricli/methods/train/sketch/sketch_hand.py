"""Sketches by the batch, as hands draw them: fast enough to draw them anew in every step of a training."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.lines.along_lines import along
from caricli.methods.sketch.fit_lines import FRONT
from caricli.models.sketch.networks import CAMERA
from caricli.models.sketch.window import CANVAS_FILL, FILL, POINTS
from caricli.template.feature_curves import FeatureCurve

LINE = 31
"""Points of a drawn line; every second one goes into the network."""

_BITS = 5
"""Of the fraction of a pixel when a line is drawn."""


@dataclass(frozen=True)
class HandSettings:
    """What hands do, as standard deviations; lengths are shares of half of the window's side.

    view: degrees of pitch, yaw and roll. scale, shift: of the sketch in its window. stretch: of its width against its
    height, and of its slant. warp: of the whole sketch, smoothly, in ``waves`` waves. offset, turn, size: of every
    stroke by itself, turn in degrees. wobble: smooth, along a stroke. jitter: of every point. ends: by how much of its
    length a stroke is too long or too short at either end; closed: how much of that where a line ends where it begins.
    doubled: chance of a sketch to be drawn over a second time. faint: chance of a sketch to be of less than full ink;
    thick: of lines of two pixels.
    """

    view: tuple[float, float, float] = (4.0, 5.0, 3.0)
    scale: float = 0.03
    shift: float = 0.023
    stretch: float = 0.02
    warp: float = 0.012
    waves: int = 4
    offset: float = 0.01
    turn: float = 2.0
    size: float = 0.03
    wobble: float = 0.006
    jitter: float = 0.003
    ends: float = 0.03
    closed: float = 0.3
    doubled: float = 0.1
    faint: float = 0.3
    thick: float = 0.3


CALM = HandSettings(stretch=0, warp=0.006, offset=0, turn=0, size=0, ends=0, doubled=0, faint=0, thick=0)
"""A hand that bends and shakes lines, but moves no stroke by itself."""


@dataclass(frozen=True, eq=False)
class Canvas:
    """Where windows are on heads that stand where heads usually do, as on a canvas whose camera is known.

    centre: (2,) metres, from the front, y down. scale: of a metre, half of the window's side is 1.
    """

    centre: np.ndarray
    scale: float

    @classmethod
    def of(cls, mean: np.ndarray, curves: Sequence[FeatureCurve]) -> "Canvas":
        """The canvas that the curves of a mean head (V, 3) fill but for a margin, in which larger heads have room."""
        flat = mean[np.concatenate([curve.vertices for curve in curves])] @ FRONT[:2].T
        low, high = flat.min(0), flat.max(0)
        return cls((low + high) / 2, float(CANVAS_FILL / ((high - low).max() / 2)))


@dataclass(frozen=True, eq=False)
class SketchBatch:
    """Drawn sketches.

    windows: (B, S, S) uint8 ink. points: (B, K, P, 2) float32 of the window, NaN where unknown. cameras: (B, 6), see
    ``networks.CAMERA``.
    """

    windows: np.ndarray
    points: np.ndarray
    cameras: np.ndarray


@dataclass(frozen=True, eq=False)
class Wrinkles:
    """Wrinkle lines on the surfaces of heads: lines (B, W, LINE, 3) metres, of which ``there`` (B, W) bool exist."""

    lines: np.ndarray
    there: np.ndarray


@dataclass(frozen=True)
class Missing:
    """Which strokes are left out.

    share: of sketches that lack strokes. fixed: the share of strokes that such a sketch lacks, None for any. unnamed:
    share of sketches whose strokes have no names.
    """

    share: float = 0.0
    fixed: float | None = None
    unnamed: float = 0.0


class SketchHand:
    """Draws the curves of heads."""

    def __init__(
        self,
        curves: Sequence[FeatureCurve],
        size: int,
        canvas: Canvas | None = None,
        settings: HandSettings = HandSettings(),  # noqa: B008 (frozen)
    ) -> None:
        """curves: FeatureCurves. size: of the windows, pixels. canvas: Canvas, or None for windows around strokes."""
        self.canvas = canvas
        self.curves = tuple(curves)
        self.ids = np.unique(np.concatenate([curve.vertices for curve in curves]))
        self.size = size
        self.settings = settings
        self._places = [np.searchsorted(self.ids, curve.vertices) for curve in curves]

    def draw(
        self,
        positions: np.ndarray,
        strength: np.ndarray,
        missing: Missing,
        generator: np.random.Generator,
        wrinkles: "Wrinkles | None" = None,
    ) -> "DrawnLines":
        """Lines of heads.

        positions: (B, I, 3) metres, of the vertices ``ids``. strength: (B,) of all that hands do, 1 as the settings
        have it. missing: Missing. wrinkles: of the same heads, or None for none.
        """
        own = self.settings
        count = len(positions)
        angles = strength[:, None] * np.radians(own.view) * generator.normal(size=(count, 3))
        rotations = np.stack([head_rotation(three)[:2] for three in angles])
        flat = positions @ rotations.swapaxes(1, 2)
        ends = strength[:, None, None] * own.ends * generator.normal(size=(count, len(self.curves), 2))
        closed = np.array([curve.closed for curve in self.curves])
        ends[:, closed] *= own.closed
        lines = np.stack([self._line(flat, k, ends[:, k]) for k in range(len(self.curves))], 1)
        there = present(lines, missing, generator)
        scale, middle = self._windows(lines, there)
        scale *= np.exp(strength * own.scale * generator.normal(size=count))
        shift = strength[:, None] * own.shift * generator.normal(size=(count, 2)) - scale[:, None] * middle
        cameras = np.concatenate([angles, np.log(scale)[:, None], shift], 1)
        assert cameras.shape[1] == CAMERA
        placed = scale[:, None, None, None] * lines + shift[:, None, None]
        full = strength[:, None, None, None]
        moved = placed + full * _moves(placed, own, generator)
        named = generator.random(count) >= missing.unnamed
        again = generator.random(count) < strength * own.doubled
        second = moved.copy()
        second[again] += full[again] * _moves(placed[again], own, generator) / 2
        ink = np.where(generator.random(count) < strength * own.faint, generator.uniform(0.4, 1, count), 1)
        width = 1 + (generator.random(count) < strength * own.thick)
        drawn = DrawnLines(moved, second, there, named, again, ink, width, cameras)
        if wrinkles is None:
            return drawn
        creases = scale[:, None, None, None] * (wrinkles.lines @ rotations.swapaxes(1, 2)[:, None])
        creases += shift[:, None, None]
        left = generator.random(wrinkles.there.shape) < there.mean(1, keepdims=True)
        bent = creases + full * _moves(creases, own, generator)
        return replace(drawn, creases=bent, creased=wrinkles.there & left)

    def batch(
        self,
        drawn: "DrawnLines",
        rows: slice = slice(None),  # noqa: B008 (frozen)
        pictures: bool = True,
        nameless: bool = False,
    ) -> SketchBatch:
        """Some rows of drawn lines as the network sees them.

        pictures: whether windows are drawn. nameless: only those of sketches whose strokes have no names.
        """
        points = drawn.lines[rows, :, :: (LINE - 1) // (POINTS - 1)].astype(np.float32)
        hidden = ~(drawn.there & drawn.named[:, None])[rows]
        points[hidden] = np.nan
        numbers = range(len(drawn.lines))[rows]
        windows = np.zeros((len(numbers), self.size, self.size), np.uint8)
        for own, number in zip(windows, numbers, strict=True):
            if pictures and not (nameless and drawn.named[number]):
                own[:] = self._picture(drawn, number)
        return SketchBatch(windows, points, drawn.cameras[rows])

    def _windows(self, lines: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Scales (B,) and middles (B, 2) of windows of lines (B, K, N, 2), of which ``there`` (B, K) are drawn."""
        if self.canvas is not None:
            return np.full(len(lines), self.canvas.scale), np.tile(self.canvas.centre, (len(lines), 1))
        low = np.where(there[..., None, None], lines, np.inf).min((1, 2))
        high = np.where(there[..., None, None], lines, -np.inf).max((1, 2))
        return FILL / ((high - low).max(1) / 2), (low + high) / 2

    def _line(self, flat: np.ndarray, number: int, ends: np.ndarray) -> np.ndarray:
        """A curve (B, LINE, 2) of flat heads, from one share of its length to another, (B, 2) beyond its ends."""
        shares = np.linspace(ends[:, 0], 1 + ends[:, 1], LINE, axis=1)
        return along(flat[:, self._places[number]], shares)

    def _picture(self, drawn: "DrawnLines", row: int) -> np.ndarray:
        import cv2

        ink = np.zeros((self.size, self.size), np.uint8)
        shade = int(round(255 * drawn.ink[row]))
        for number, lines in enumerate((drawn.lines, drawn.second)[: 1 + drawn.again[row]]):
            pixels = (self.size - 1) / 2 * (1 + np.clip(lines[row][drawn.there[row]], -3, 3))
            if not number and drawn.creases is not None and drawn.creased is not None:
                bent = (self.size - 1) / 2 * (1 + np.clip(drawn.creases[row][drawn.creased[row]], -3, 3))
                pixels = np.concatenate([pixels, bent])
            fixed = np.rint(pixels * (1 << _BITS)).astype(np.int32)
            cv2.polylines(ink, list(fixed), False, shade, int(drawn.width[row]), cv2.LINE_AA, _BITS)
        return ink


@dataclass(frozen=True, eq=False)
class DrawnLines:
    """Lines in windows, before they are pictures.

    lines, second: (B, K, LINE, 2) of the window, drawn first and again. there: (B, K) bool. named, again: (B,) bool.
    ink: (B,) 0 to 1. width: (B,) pixels. cameras: (B, 6). creases: (B, W, LINE, 2) wrinkle lines, of which ``creased``
    (B, W) are drawn; None where wrinkles are not.
    """

    lines: np.ndarray
    second: np.ndarray
    there: np.ndarray
    named: np.ndarray
    again: np.ndarray
    ink: np.ndarray
    width: np.ndarray
    cameras: np.ndarray
    creases: np.ndarray | None = None
    creased: np.ndarray | None = None


def present(lines: np.ndarray, missing: Missing, generator: np.random.Generator) -> np.ndarray:
    """(B, K) bool: which strokes are drawn.

    Half of the sketches lack any of their strokes, half rather the short ones, as people leave them out (Yu et al. 2016
    remove strokes by length and order); at least two stay.
    """
    count, curves = lines.shape[:2]
    lengths = np.linalg.norm(np.diff(lines, axis=2), axis=3).sum(2)
    lacking = np.less(generator.random(count), missing.share)
    share = generator.random(count) if missing.fixed is None else np.full(count, missing.fixed)
    by_length = np.less(generator.random(count), 0.5 if missing.fixed is None else 0)
    chance = np.where(by_length[:, None], lengths / lengths.mean(1, keepdims=True), 1)
    # The smallest of exponential variables over their rates stay: a draw without replacement.
    order = np.argsort(np.argsort(generator.exponential(size=lengths.shape) / chance, axis=1), axis=1)
    kept = np.maximum(np.rint(curves * (1 - share)), 2)
    return ~lacking[:, None] | (order < kept[:, None])


def _moves(lines: np.ndarray, own: HandSettings, generator: np.random.Generator) -> np.ndarray:
    """What a hand does to lines (B, K, N, 2) in their windows, at full strength."""
    count, curves, along_line, _ = lines.shape
    moves = lines @ (own.stretch * generator.normal(size=(count, 1, 2, 2)))
    waves = generator.normal(size=(own.waves, count, 1, 1, 2)) * 2.5
    phases = generator.uniform(0, 2 * np.pi, (own.waves, count, 1, 1))
    sizes = own.warp * generator.normal(size=(own.waves, count, 1, 1, 2)) / np.sqrt(own.waves / 2)
    for wave, phase, size in zip(waves, phases, sizes, strict=True):
        moves += size * np.sin(lines[..., 0] * wave[..., 0] + lines[..., 1] * wave[..., 1] + phase)[..., None]
    centred = lines - lines.mean(2, keepdims=True)
    turn = np.radians(own.turn) * generator.normal(size=(count, curves, 1, 1))
    moves += centred[..., ::-1] * turn * [-1, 1] + centred * own.size * generator.normal(size=(count, curves, 1, 2))
    moves += own.offset * generator.normal(size=(count, curves, 1, 2))
    places = np.linspace(0, np.pi, along_line)[:, None]
    waves_along = np.cos(places * [1, 2, 3, 5])
    moves += (own.wobble / np.sqrt(2) * waves_along) @ generator.normal(size=(count, curves, 4, 2))
    return moves + own.jitter * generator.normal(size=lines.shape)
