"""Which folds a person's skin has, and which actions draw them (Ekman and Friesen 1978, facial action coding)."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.rows_at import rows_at
from caricli.geometry.smooth_step import smooth_step
from caricli.methods.creases import crease_lines as lines

_SPACING = 0.35  # of a crease's width, between points of its path
_WAVES = 3  # that a hand of nature bends a path with

Gains = Mapping[str, np.ndarray | float]
"""By ARKit actions how much of the full depth each draws, (M,) along the path or for all of it."""


@dataclass(frozen=True, eq=False)
class Crease:
    """One fold. Lengths are widths of the face between the eyes' outer corners.

    path: (M, 2) across and up on the usual face. width: from its bottom to where it is a third as deep. depth: at its
    deepest. envelope: (M,) from 0 to 1, how deep along the path. resting: of the depth without expression. gains: of
    actions. bulge: height of the fold beside it, of its depth, and on which side: positive left of the path.
    stain: how much darker its bottom is, of logarithms.
    """

    path: np.ndarray
    width: float
    depth: float
    envelope: np.ndarray
    resting: float
    gains: Gains
    bulge: float
    stain: float

    def strength(self, weights: Mapping[str, float]) -> np.ndarray:
        """(M,) from 0 to 1 how far it is drawn by weights of actions."""
        drawn = self.resting + sum(weights.get(name, 0.0) * gain for name, gain in self.gains.items())
        return self.envelope * np.clip(drawn, 0, 1)


@dataclass(frozen=True, eq=False)
class CreasePattern:
    """The folds of a person. age: of the skin, 0 young to 1 old. flush: how easily it reddens, 0 to 1."""

    creases: tuple[Crease, ...]
    age: float
    flush: float

    def deepened(self, factor: float) -> "CreasePattern":
        """The same folds, so much deeper and darker."""
        deeper = [replace(one, depth=factor * one.depth, stain=factor * one.stain) for one in self.creases]
        return replace(self, creases=tuple(deeper))


@dataclass(frozen=True)
class Kind:
    """A kind of fold. depth, width: ranges. resting: of the oldest skin, of the depth. bulge, stain: see ``Crease``.

    young: share of the depth that the youngest skin has. wave: how far paths wander.
    """

    depth: tuple[float, float]
    width: tuple[float, float]
    resting: float
    bulge: float = 0.0
    stain: float = 0.45
    young: float = 0.35
    wave: float = 0.012


KINDS = {
    "forehead": Kind((0.018, 0.034), (0.014, 0.024), 0.3),
    "frown": Kind((0.022, 0.04), (0.015, 0.025), 0.35),
    "root": Kind((0.015, 0.028), (0.014, 0.022), 0.2),
    "crow": Kind((0.012, 0.022), (0.01, 0.016), 0.3),
    "bag": Kind((0.014, 0.026), (0.015, 0.026), 0.4, 0.3),
    "bunny": Kind((0.012, 0.022), (0.011, 0.017), 0.08),
    "smile": Kind((0.026, 0.048), (0.024, 0.038), 0.35, 0.5, 0.55, 0.5),
    "cheek": Kind((0.016, 0.028), (0.022, 0.034), 0.12, 0.3),
    "dimple": Kind((0.014, 0.026), (0.022, 0.035), 0.0, 0.0, 0.25, 1.0),
    "corner": Kind((0.014, 0.028), (0.018, 0.028), 0.35, 0.3),
    "groove": Kind((0.018, 0.03), (0.035, 0.05), 0.15, 0.0, 0.35, 0.7),
    "pit": Kind((0.006, 0.013), (0.014, 0.022), 0.0, 0.0, 0.3, 0.5, 0.0),
    "lip": Kind((0.005, 0.011), (0.008, 0.012), 0.25, 0.0, 0.4, 0.3, 0.004),
}
"""Tuned by eye on generated people; 0.01 is nearly a millimetre."""


def random_pattern(marks: np.ndarray, age: float, generator: np.random.Generator) -> CreasePattern:
    """Draw a person's own pattern: how many lines, where, how deep, how wide, how unlike both sides.

    marks: (68, 2) landmarks of the usual face, in widths. age: of the skin, 0 to 1.
    """
    draw = _Draw(marks, age, generator)
    creases = [*draw.forehead(), *draw.brows(), *draw.chin(), *draw.lips()]
    for side in (-1, 1):
        creases += [*draw.eye(side), *draw.cheek(side)]
    return CreasePattern(tuple(creases), age, float(generator.uniform(0.2, 1)))


class _Draw:
    """Draws the folds of one person, region by region."""

    def __init__(self, marks: np.ndarray, age: float, generator: np.random.Generator) -> None:
        self.marks = marks
        self.age = age
        self.generator = generator
        # Sides share most of what they have.
        self.deep = generator.uniform(0.6, 1.15)
        self.numbers = {
            "crow": int(generator.integers(2, 6)),
            "bag": int(generator.integers(1, 4)),
            "bunny": int(generator.integers(2, 4)),
            "cheek": int(generator.integers(0, 3)),
        }
        self.dimpled = generator.random() < 0.35

    def forehead(self) -> Iterator[Crease]:
        """Lines that raised brows draw, deepest in the middle or at the sides."""
        generator = self.generator
        count = int(generator.integers(2, 6))
        middle = generator.uniform(0.3, 1)
        for rise in np.linspace(0.1, generator.uniform(0.32, 0.46), count) + generator.normal(0, 0.012, count):
            x = lines.forehead_line(self.marks, rise)[:, 0]
            gains = {"browInnerUp": middle + (1 - middle) * np.exp(-((x / 0.3) ** 2))}
            for name, side in (("browOuterUpRight", -1), ("browOuterUpLeft", 1)):
                gains[name] = 0.8 * smooth_step(side * x, -0.1, 0.2)
            gains["browDownLeft"] = gains["browDownRight"] = np.full(len(x), -0.2)
            yield self.crease("forehead", partial(lines.forehead_line, self.marks, rise), gains, reach=0.85)

    def brows(self) -> Iterator[Crease]:
        """Lines between the brows."""
        generator = self.generator
        for side, own in ((-1, "Right"), (1, "Left")):
            if generator.random() < 0.85:
                other = "Left" if own == "Right" else "Right"
                gains = {f"browDown{own}": 0.75, f"browDown{other}": 0.25, f"noseSneer{own}": 0.15, "browInnerUp": 0.12}
                yield self.crease("frown", partial(lines.frown_line, self.marks, side), gains)
        for _ in range(int(generator.integers(1, 3))):
            gains = {f"{name}{side}": 0.35 for name in ("browDown", "noseSneer") for side in ("Left", "Right")}
            yield self.crease("root", partial(lines.root_line, self.marks, generator.uniform(-0.04, 0.05)), gains)

    def eye(self, side: int) -> Iterator[Crease]:
        """Crow's feet, and lines and bags below an eye."""
        generator = self.generator
        own = _own(side)
        gains = {f"eyeSquint{own}": 0.8, f"cheekSquint{own}": 0.7, f"mouthSmile{own}": 0.35, f"eyeBlink{own}": 0.15}
        for rise in np.linspace(0.13, -0.14, self.numbers["crow"]) + generator.normal(0, 0.012, self.numbers["crow"]):
            yield self.crease("crow", partial(lines.crow_line, self.marks, side, rise), gains)
        gains = {f"eyeSquint{own}": 0.75, f"cheekSquint{own}": 0.75, f"mouthSmile{own}": 0.2}
        for k in range(self.numbers["bag"]):
            drop = 0.045 * k - 0.03 + generator.normal(0, 0.006)
            yield self.crease("bag", partial(lines.bag_line, self.marks, side, drop), gains)

    def cheek(self, side: int) -> Iterator[Crease]:
        """Folds beside nose and mouth."""
        generator = self.generator
        own = _own(side)
        marks = self.marks
        for share in np.linspace(0.25, 0.6, self.numbers["bunny"]) + generator.normal(0, 0.03, self.numbers["bunny"]):
            gains = {f"noseSneer{own}": 1.0, f"mouthUpperUp{own}": 0.15, f"cheekSquint{own}": 0.1}
            yield self.crease("bunny", partial(lines.bunny_line, marks, side, share), gains)
        gains = {f"mouthSmile{own}": 0.8, f"noseSneer{own}": 0.6, f"mouthUpperUp{own}": 0.35}
        gains |= {f"cheekSquint{own}": 0.2, f"mouthStretch{own}": 0.25, f"mouthDimple{own}": 0.2}
        yield self.crease("smile", partial(lines.smile_fold, marks, side), gains)
        gains = {f"mouthSmile{own}": 0.75, f"mouthStretch{own}": 0.4, f"mouthDimple{own}": 0.3}
        for k in range(self.numbers["cheek"]):
            yield self.crease("cheek", partial(lines.smile_fold, marks, side, 0.1 + 0.09 * k), gains)
        if self.dimpled:
            gains = {f"mouthSmile{own}": 0.6, f"mouthDimple{own}": 0.9}
            yield self.crease("dimple", partial(lines.dimple, marks, side), gains)
        gains = {f"mouthFrown{own}": 0.75, f"mouthPress{own}": 0.3, f"mouthStretch{own}": 0.3, "mouthShrugLower": 0.3}
        gains["mouthPucker"] = -0.2
        yield self.crease("corner", partial(lines.corner_fold, marks, side), gains)

    def chin(self) -> Iterator[Crease]:
        """The groove above the chin, and its dimpled skin."""
        generator = self.generator
        gains = {"mouthShrugLower": 0.9, "mouthPucker": 0.4, "mouthFrownLeft": 0.25, "mouthFrownRight": 0.25}
        yield self.crease("groove", partial(lines.chin_groove, self.marks), gains)
        gains = {"mouthShrugLower": 1.0, "mouthShrugUpper": 0.3, "mouthPucker": 0.25}
        gains |= {"mouthFrownLeft": 0.3, "mouthFrownRight": 0.3}
        for _ in range(int(generator.integers(12, 26))):
            across = generator.normal(0, 0.08)
            yield self.crease("pit", partial(lines.chin_pit, self.marks, across, generator.uniform(0.5, 0.9)), gains)

    def lips(self) -> Iterator[Crease]:
        """Short lines across the lips and beyond them."""
        generator = self.generator
        gains = {"mouthPucker": 0.9, "mouthFunnel": 0.4, "mouthPressLeft": 0.2, "mouthPressRight": 0.2}
        gains |= {f"mouthStretch{side}": -0.4 for side in ("Left", "Right")}
        for side in (1, -1):
            for share in np.linspace(0.2, 0.8, int(generator.integers(5, 11))):
                place = share + generator.normal(0, 0.02)
                length = generator.uniform(0.05, 0.14)
                yield self.crease("lip", partial(lines.lip_line, self.marks, side, place, length), gains)

    def crease(self, kind: str, line: Callable[[], np.ndarray], gains: Gains, reach: float = 0.7) -> Crease:
        """A fold along a line, as this person has it. reach: of its length, at the least."""
        generator = self.generator
        usual = KINDS[kind]
        width = generator.uniform(*usual.width)
        path, at = _wander(line(), usual.wave, _SPACING * width, generator)
        ends = np.array([0, 1]) + np.array([1, -1]) * generator.uniform(0, (1 - reach) / 2 + 0.05, 2)
        envelope = smooth_step(at, ends[0], ends[0] + 0.22) * smooth_step(-at, -ends[1], 0.22 - ends[1])
        envelope *= 1 - generator.uniform(0, 0.5) * np.exp(-(((at - generator.random()) / 0.08) ** 2))
        depth = generator.uniform(*usual.depth) * self.deep * (usual.young + (1 - usual.young) * self.age)
        resting = usual.resting * self.age**1.5 * generator.uniform(0.3, 1.6)
        gain = generator.uniform(0.8, 1.2)
        along = {name: gain * _resampled(value, at) for name, value in gains.items()}
        # Left of a path that goes down the left side is the cheek; one below the left eye goes inwards.
        out = usual.bulge * np.sign(path[:, 0].mean()) * (-1 if kind == "bag" else 1)
        stain = usual.stain * generator.uniform(0.6, 1.3) * (0.6 + 0.4 * self.age)
        return Crease(path, width, depth, envelope, resting, along, float(out), float(stain))


def _own(side: int) -> str:
    return "Left" if side > 0 else "Right"


def _resampled(value: np.ndarray | float, at: np.ndarray) -> np.ndarray | float:
    """A value along a line at shares (M,) of its length; one number stays what it is."""
    if isinstance(value, np.ndarray):
        return np.asarray(np.interp(at, np.linspace(0, 1, len(value)), value))
    return value


def _wander(
    line: np.ndarray, wave: float, spacing: float, generator: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """A line (N, 2) as a hand of nature draws it: points (M, 2), and shares (M,) of its length."""
    lengths = arc_lengths(line)
    at = np.linspace(0, 1, max(int(lengths[-1] / spacing), 5))
    path = rows_at(at, lengths / lengths[-1], line)
    phases = generator.uniform(0, 2 * np.pi, (_WAVES, 2))
    sizes = wave * generator.normal(size=(_WAVES, 2)) / (1 + np.arange(_WAVES)[:, None])
    turns = np.pi * (1 + 2 * np.arange(_WAVES))[:, None] * at
    moved = np.stack([(sizes[:, [k]] * np.cos(turns + phases[:, [k]])).sum(0) for k in (0, 1)], 1)
    return path + min(1.0, 3 * lengths[-1]) * moved, at
