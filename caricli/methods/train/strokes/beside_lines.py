"""What people draw beside the curves of a face: irises, hair, necks, teeth, glasses, and lines of no meaning."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.match_line import resample

Curves = Mapping[str, np.ndarray]
"""Lines (N, 2) of a face by the names of the curves that they draw, y down."""


@dataclass(frozen=True)
class BesideSettings:
    """Chances, 0 to 1, that a sketch has such lines.

    bare: that it has none of them. iris, pupil: the latter of a sketch with irises. glasses, hair, hairline, strands,
    neck, collar, whorl, teeth: the like. strays: how many lines of no meaning in the mean.
    """

    bare: float = 0.25
    iris: float = 0.6
    pupil: float = 0.5
    glasses: float = 0.08
    hair: float = 0.55
    hairline: float = 0.45
    strands: float = 0.3
    neck: float = 0.45
    collar: float = 0.5
    whorl: float = 0.3
    teeth: float = 0.6
    strays: float = 1.0


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where a face is: the box around its lines, low and high (2,), and the height of its brows and eyes."""

    low: np.ndarray
    high: np.ndarray
    brows: float

    @classmethod
    def of(cls, curves: Curves) -> "_Frame":
        points = np.concatenate(list(curves.values()))
        upper = [line for name, line in curves.items() if name.startswith(("brow", "eye"))]
        low, high = points.min(0), points.max(0)
        brows = np.concatenate(upper)[:, 1].min() if upper else low[1]
        return cls(low, high, float(min(brows, high[1] - 0.3 * (high - low)[1])))

    @property
    def height(self) -> float:
        return float(self.high[1] - self.low[1])

    def arch(self, wide: float, top: float) -> np.ndarray:
        """(24, 2) from temple to temple over the head. wide: of the face's. top: where it is highest."""
        turn = np.linspace(np.pi, 2 * np.pi, 24)
        middle = (self.low[0] + self.high[0]) / 2
        foot = self.brows + 0.1 * self.height
        half = wide * (self.high[0] - self.low[0]) / 2
        return np.stack([middle + half * np.cos(turn), foot + (foot - top) * np.sin(turn)], 1)


def lines_beside(
    curves: Curves,
    generator: np.random.Generator,
    settings: BesideSettings = BesideSettings(),  # noqa: B008 (frozen)
) -> list[np.ndarray]:
    """Lines (N, 2) that draw no curve of a face. curves: of the face, one at least."""
    if generator.random() < settings.bare:
        return []
    frame = _Frame.of(curves)
    return [
        *_eyes(curves, generator, settings),
        *_hair(frame, generator, settings),
        *_shoulders(frame, generator, settings),
        *_whorls(curves, generator, settings),
        *_teeth(curves, frame, generator, settings),
        *_strays(frame, generator, settings),
    ]


def _eyes(curves: Curves, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    iris = generator.random() < own.iris
    pupil = iris and generator.random() < own.pupil
    glasses = generator.random() < own.glasses
    glance = 0.06 * generator.normal(size=2)
    size, wide = generator.uniform(0.4, 0.75), generator.uniform(0.7, 1.1)
    lines: list[np.ndarray] = []
    for side in ("left", "right"):
        lids = [curves.get(f"eye_{which}_{side}") for which in ("upper", "lower")]
        upper, lower = lids
        if upper is None or lower is None:
            continue
        width = float(np.ptp(upper[:, 0]))
        opening = max(float(lower[:, 1].max() - upper[:, 1].min()), width / 8)
        middle = (upper.mean(0) + lower.mean(0)) / 2
        radius = min(size * opening, width / 4)
        turn = generator.uniform(0, 6)
        if iris:
            lines.append(_oval(middle + glance * width, radius, generator.uniform(0.9, 1.1) * radius, turn))
        if pupil:
            lines.append(_oval(middle + glance * width, 0.4 * radius, 0.4 * radius, turn))
        if glasses:
            lines.append(_oval(middle, wide * width, generator.uniform(0.7, 1) * wide * width, turn))
    return lines


def _hair(frame: _Frame, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    height = frame.height
    top = frame.low[1] - height * generator.uniform(-0.03, 0.35)
    lines = []
    if generator.random() < own.hair:
        arch = frame.arch(generator.uniform(0.95, 1.3), top)
        lines.append(unsteady(arch, height * generator.uniform(0, 0.03), generator))
    if generator.random() < own.hairline:
        edge = frame.low[1] + generator.uniform(0, 0.7) * (frame.brows - frame.low[1])
        lines.append(
            unsteady(frame.arch(generator.uniform(0.65, 1), edge), height * generator.uniform(0, 0.03), generator)
        )
    if generator.random() < own.strands:
        for _ in range(generator.integers(2, 12)):
            arch = frame.arch(generator.uniform(0.6, 1.2), top + generator.uniform(-0.1, 0.7) * (frame.brows - top))
            start = int(generator.integers(0, len(arch) - 8))
            lines.append(unsteady(arch[start : start + int(generator.integers(3, 8))], 0.01 * height, generator))
    return lines


def _shoulders(frame: _Frame, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    if generator.random() >= own.neck:
        return []
    middle = (frame.low[0] + frame.high[0]) / 2
    half = generator.uniform(0.3, 0.8) * (frame.high[0] - frame.low[0]) / 2
    top = frame.high[1] - generator.uniform(0, 0.2) * frame.height
    bottom = frame.high[1] + generator.uniform(0.05, 0.4) * frame.height
    lines = []
    for side in (-1, 1):
        foot = middle + side * half * generator.uniform(0.9, 1.4)
        ends = np.array([[middle + side * half, top], [foot, bottom]])
        lines.append(unsteady(ends, 0.01 * frame.height, generator))
    if generator.random() < own.collar:
        tip = bottom + 0.15 * frame.height
        collar = np.array([[middle - 2 * half, bottom], [middle, tip], [middle + 2 * half, bottom]])
        lines.append(unsteady(collar, 0.01 * frame.height, generator))
    return lines


def _whorls(curves: Curves, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    """Lines within ears."""
    lines = []
    for name in ("ear_left", "ear_right"):
        if name in curves and generator.random() < own.whorl:
            ear = curves[name]
            middle = ear.mean(0)
            inner = middle + generator.uniform(0.4, 0.75) * (ear - middle)
            lines.append(unsteady(inner, 0.03 * float(np.ptp(ear[:, 1])), generator))
    return lines


def _teeth(curves: Curves, frame: _Frame, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    upper, lower = (curves.get(f"mouth_inner_{which}") for which in ("upper", "lower"))
    if upper is None or lower is None or generator.random() >= own.teeth:
        return []
    if lower[:, 1].mean() - upper[:, 1].mean() < 0.03 * frame.height:
        return []
    columns = np.linspace(upper[:, 0].min(), upper[:, 0].max(), int(generator.integers(5, 12)))[1:-1]
    tops, bottoms = (np.interp(columns, *line[line[:, 0].argsort()].T) for line in (upper, lower))
    ends = tops + generator.uniform(0.4, 1) * (bottoms - tops)
    lines = [np.array([[x, top], [x, end]]) for x, top, end in zip(columns, tops, ends, strict=True)]
    if generator.random() < 0.5:
        lines.append(unsteady(np.stack([columns, ends], 1), 0.004 * frame.height, generator))
    return lines


def _strays(frame: _Frame, generator: np.random.Generator, own: BesideSettings) -> list[np.ndarray]:
    lines = []
    for _ in range(generator.poisson(own.strays)):
        start = frame.low + (frame.high - frame.low) * generator.uniform(-0.05, 1.1, 2)
        end = start + frame.height * generator.uniform(0.03, 0.15) * generator.normal(size=2)
        lines.append(unsteady(np.stack([start, end]), 0.02 * frame.height, generator))
    return lines


def unsteady(line: np.ndarray, size: float, generator: np.random.Generator) -> np.ndarray:
    """A line (N, 2) as (32, 2), with waves of about a size."""
    along = np.linspace(0, 1, 32)[:, None]
    moved = resample(line, len(along)) if np.ptp(line, axis=0).any() else np.repeat(line[:1], len(along), 0)
    for wave in range(1, 6):
        moved = moved + size / wave * generator.normal(size=2) * np.sin(
            2 * np.pi * wave * along + generator.uniform(0, 2 * np.pi)
        )
    return moved


def _oval(middle: np.ndarray, wide: float, high: float, start: float) -> np.ndarray:
    turn = start + np.linspace(0, 2 * np.pi, 28)
    return middle + np.stack([wide * np.cos(turn), high * np.sin(turn)], 1)
