"""Gestures as many hands draw them: what the gesture network learns from."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.match_line import resample
from caricli.geometry.lines.rows_at import rows_at
from caricli.structures.gesture import GESTURES, roll_level

_DENSE = 240
"""Points of a stroke before a hand draws it."""


@dataclass(frozen=True)
class GestureHandSettings:
    """What hands do; lengths are shares of the stroke's size (the diagonal of its box), angles degrees.

    turn: standard deviation of the whole stroke's direction. slant: of its shear. stretch: of the logarithm of its
    width against its height. tremor: largest amplitude of an unsteady pen. cut: largest length over which corners are
    cut. past: largest length by which ends go on. points: least and most that are told of a stroke.
    """

    turn: float = 8.0
    slant: float = 0.25
    stretch: float = 0.2
    tremor: float = 0.015
    cut: float = 0.03
    past: float = 0.05
    points: tuple[int, int] = (16, 120)


def draw_gesture(
    name: str,
    generator: np.random.Generator,
    settings: GestureHandSettings = GestureHandSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """A stroke (N, 2), pixels, y down, of one of GESTURES, anywhere and of any size."""
    shape = ideal_gesture(name, generator)
    shape = shape @ _shear(settings, generator)
    if generator.random() < 0.5:
        shape = shape[::-1]
    stroke = _at_speed(_unsteady(shape, settings, generator), abs(roll_level(name)), settings, generator)
    return stroke * generator.uniform(40, 500) + generator.uniform(0, 1000, 2)


def draw_other(generator: np.random.Generator) -> np.ndarray:
    """A stroke (N, 2), pixels, y down, that is no gesture: a zigzag, a spiral, too many loops, or a scribble."""
    shape = _OTHERS[int(generator.integers(len(_OTHERS)))](generator)
    settings = GestureHandSettings()
    stroke = _at_speed(_unsteady(_sized(shape), settings, generator), 3, settings, generator)
    return stroke * generator.uniform(40, 500) + generator.uniform(0, 1000, 2)


def ideal_gesture(name: str, generator: np.random.Generator) -> np.ndarray:
    """A gesture (N, 2) as somebody means it, of size one, y down."""
    level = roll_level(name)
    if level:
        shape = _roll(abs(level), generator) * [1, -1 if level > 0 else 1]
    elif name.endswith("_arrow"):
        shape = _arrow(generator) * [1 if name.startswith("right") else -1, 1]
    else:
        assert name in GESTURES
        shape = _region(generator) if name == "region" else _line(generator)
    return _sized(shape)


def _sized(shape: np.ndarray) -> np.ndarray:
    dense = resample(shape, _DENSE)
    return (dense - dense.mean(0)) / np.linalg.norm(np.ptp(dense, axis=0))


def _line(generator: np.random.Generator) -> np.ndarray:
    """A straight or smoothly bent line in any direction; its own direction changes by 200 degrees at most."""
    along = np.linspace(0, 1, _DENSE)
    waves = np.cos(np.pi * along[:, None] * [1, 2, 3, 4]) @ (generator.normal(size=4) / [1, 2, 3, 4])
    waves /= max(float(np.ptp(waves)), 1e-6)
    turned = np.radians(200) * generator.beta(1, 1.5) * waves + generator.uniform(0, 2 * np.pi)
    return np.cumsum(np.stack([np.cos(turned), np.sin(turned)], 1), axis=0)


def _region(generator: np.random.Generator) -> np.ndarray:
    """A closed line, round to nearly square, dented, begun anywhere, that ends too early or too late."""
    extent = 1 + generator.uniform(-0.12, 0.12)
    angles = generator.uniform(0, 2 * np.pi) + 2 * np.pi * extent * np.linspace(0, 1, _DENSE)
    power = 2 / generator.uniform(1.6, 5)
    circle = np.stack([np.cos(angles), np.sin(angles)], 1)
    shape = np.sign(circle) * np.abs(circle) ** power * [1, generator.uniform(0.3, 1)]
    dent = 1 - generator.uniform(0, 0.35) * np.exp(-(((angles - generator.uniform(0, 12)) % (2 * np.pi) - 3) ** 2))
    late = 1 + generator.uniform(-0.12, 0.12) * np.linspace(-1, 1, _DENSE)
    turn = generator.uniform(0, 2 * np.pi)
    return shape * (dent * late)[:, None] @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]


def _arrow(generator: np.random.Generator) -> np.ndarray:
    """An arrow to the right: a chevron, or a shaft and a head in one stroke."""
    opening = np.radians(generator.uniform(20, 50, 2) * [1, -1])
    barbs = -np.stack([np.cos(opening), np.sin(opening)], 1) * generator.uniform(0.75, 1.3, (2, 1))
    tip = np.zeros((1, 2))
    if generator.random() < 0.5:
        return np.concatenate([barbs[:1], tip, barbs[1:]])
    barbs = barbs * generator.uniform(0.25, 0.55)
    tail = np.array([[-1.0, generator.normal(0, 0.05)]])
    if generator.random() < 0.5:
        return np.concatenate([tail, tip, barbs[:1], tip, barbs[1:]])
    return np.concatenate([tail, tip, barbs[:1], barbs[1:], tip])


def _roll(count: int, generator: np.random.Generator) -> np.ndarray:
    """A line to the right with loops above it (y up): a trochoid between two leads, which goes on between its loops or
    during them."""
    advance = generator.uniform(0.6, 3.2)
    angles = np.linspace(0, 2 * np.pi * count, _DENSE)
    sizes = generator.uniform(0.7, 1.3, count + 1)
    size = np.interp(angles, 2 * np.pi * np.arange(count + 1), sizes)
    turns = (angles + generator.uniform(-0.5, 1) * np.sin(angles)) / (2 * np.pi)
    x = advance * turns + size * generator.uniform(0.7, 1.5) * np.sin(angles)
    loops = np.stack([x, size * generator.uniform(0.7, 2.4) * (1 - np.cos(angles))], 1)
    bends = generator.normal(0, 0.3, (2, 1)) * [0, 1]
    before = np.linspace(1, 0, 40)[:-1, None] * [-generator.uniform(0.6, 3.5), 0]
    after = np.linspace(0, 1, 40)[1:, None] * [generator.uniform(0.6, 3.5), 0]
    before += np.linspace(1, 0, 40)[:-1, None] ** 2 * bends[0]
    after += np.linspace(0, 1, 40)[1:, None] ** 2 * bends[1]
    return np.concatenate([before, loops, after + loops[-1]])


def _shear(settings: GestureHandSettings, generator: np.random.Generator) -> np.ndarray:
    """(2, 2) the turn, slant and stretch of a hand."""
    turn = np.radians(settings.turn * generator.normal())
    stretch = np.exp(settings.stretch * generator.normal() / 2)
    slant = np.array([[stretch, 0], [settings.slant * generator.normal(), 1 / stretch]])
    return slant @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])


def _unsteady(shape: np.ndarray, settings: GestureHandSettings, generator: np.random.Generator) -> np.ndarray:
    """A stroke (M, 2) of size one with corners cut, ends that go on, and tremor."""
    from scipy.ndimage import gaussian_filter1d

    length = np.linalg.norm(np.diff(shape, axis=0), axis=1).sum()
    dense = resample(shape, _DENSE)
    cut = generator.uniform(0, settings.cut) / length * _DENSE
    dense = gaussian_filter1d(dense, cut + 0.01, axis=0, mode="nearest")
    beyond = []
    for end, inner in ((dense[0], dense[8]), (dense[-1], dense[-9])):
        away = (end - inner) / max(float(np.linalg.norm(end - inner)), 1e-9)
        beyond.append(end + away * generator.uniform(0, settings.past))
    dense = resample(np.concatenate([beyond[:1], dense, beyond[1:]]), _DENSE)
    shake = gaussian_filter1d(generator.normal(size=dense.shape), generator.uniform(3, 20), axis=0)
    return dense + generator.uniform(0, settings.tremor) * shake / max(float(shake.std()), 1e-9)


def _at_speed(
    dense: np.ndarray, loops: int, settings: GestureHandSettings, generator: np.random.Generator
) -> np.ndarray:
    """The points (N, 2) that are told of a pen that goes quicker and slower; at least twelve a loop."""
    low, high = settings.points
    count = int(np.exp(generator.uniform(np.log(max(low, 12 * loops + 6)), np.log(high))))
    pace = np.exp(np.cumsum(generator.normal(0, 0.5 / np.sqrt(count), count)))
    places = np.concatenate([[0], np.cumsum(pace)]) / pace.sum() * (len(dense) - 1)
    return rows_at(places, np.arange(len(dense)), dense)


def _zigzag(generator: np.random.Generator) -> np.ndarray:
    count = int(generator.integers(4, 9))
    x = np.cumsum(generator.uniform(0.2, 1, count))
    corners = np.stack([x, np.where(np.arange(count) % 2, 1, -1) * generator.uniform(0.6, 2, count)], 1)
    return corners if generator.random() < 0.7 else corners[:, ::-1]


def _spiral(generator: np.random.Generator) -> np.ndarray:
    angles = np.linspace(0, generator.uniform(4, 8) * np.pi, _DENSE) + generator.uniform(0, 6)
    return np.linspace(generator.uniform(0, 0.4), 1, _DENSE)[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)


def _many_loops(generator: np.random.Generator) -> np.ndarray:
    return _roll(int(generator.integers(5, 9)), generator) * [1, generator.choice([-1.0, 1.0])]


def _scribble(generator: np.random.Generator) -> np.ndarray:
    return np.cumsum(generator.normal(size=(int(generator.integers(7, 16)), 2)), axis=0)


_OTHERS = (_zigzag, _spiral, _many_loops, _scribble)
