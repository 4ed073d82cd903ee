"""Gestures of hands of another kind than those that the network learnt from.

Shapes are put together from other curves (Bezier curves, ellipses, polygons), and what hands do to them is of other
families: a pen that lags behind like a mass on a spring, a periodic tremor, paper that is warped as a whole, writing
that grows or bends on its way, hooks where the pen is set down and lifted, whole pixels, and events that get lost.
"""

import numpy as np

from caricli.geometry.lines.match_line import resample
from caricli.structures.gesture import roll_level

_DENSE = 300


def strange_gesture(name: str, generator: np.random.Generator) -> np.ndarray:
    """A stroke (N, 2), pixels, y down, of one of GESTURES."""
    level = roll_level(name)
    if level:
        shape = _loops(abs(level), generator) * [1, -1 if level > 0 else 1]
    elif name.endswith("_arrow"):
        shape = _bowed_arrow(generator) * [1 if name.startswith("right") else -1, 1]
    else:
        shape = _loop_of_corners(generator) if name == "region" else _bezier_line(generator)
    return _drawn(shape if generator.random() < 0.5 else shape[::-1], abs(level), generator)


def strange_other(generator: np.random.Generator) -> np.ndarray:
    """A stroke (N, 2), pixels, y down, that is no gesture: a Lissajous figure, hatching, a star, or a letter."""
    return _drawn(_OTHERS[int(generator.integers(len(_OTHERS)))](generator), 3, generator)


def _drawn(shape: np.ndarray, loops: int, generator: np.random.Generator) -> np.ndarray:
    """What a stranger makes of a shape (M, 2), y down."""
    dense = resample(shape, _DENSE)
    dense = (dense - dense.mean(0)) / np.linalg.norm(np.ptp(dense, axis=0))
    dense = _lagging(_warped(_growing(dense, generator), generator), generator)
    dense = _hooked(dense, generator)
    along = np.linspace(0, 1, len(dense))
    phase = 2 * np.pi * (generator.uniform(10, 40) * along + generator.uniform(0, 1) * np.sin(5 * along))
    dense += generator.uniform(0, 0.008) * np.stack([np.sin(phase), np.cos(1.3 * phase)], 1)
    count = int(generator.integers(20 + 12 * loops, 90 + 12 * loops))
    stroke = dense[np.linspace(0, len(dense) - 1, count).astype(int)]
    if generator.random() < 0.3:
        lost = int(generator.integers(1, count - 4))
        stroke = np.delete(stroke, slice(lost, lost + max(2, count // 30)), axis=0)
    return np.round(stroke * generator.uniform(60, 400) + generator.uniform(100, 900, 2))


def _growing(dense: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Writing that becomes larger or smaller on its way to the right, and bends."""
    growth = np.exp(generator.normal(0, 0.25) * dense[:, :1])
    bend = generator.normal(0, 0.3)
    bent = dense * growth
    return bent + np.stack([np.zeros(len(bent)), bend * bent[:, 0] ** 2], 1)


def _warped(dense: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """A stroke on paper that is warped."""
    waves = generator.normal(0, 4, (2, 2))
    return dense + generator.uniform(0, 0.03) * np.sin(dense @ waves + generator.uniform(0, 6, 2))


def _lagging(dense: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """The way of a mass on a spring that is drawn along a stroke, and where it comes to rest."""
    stiff = generator.uniform(0.25, 0.8)
    damping = generator.uniform(0.55, 0.95)
    way = np.concatenate([dense, np.repeat(dense[-1:], 12, 0)])
    place = way[0].copy()
    speed = np.zeros(2)
    drawn = []
    for goal in way:
        speed = (1 - damping) * speed + stiff * (goal - place)
        place = place + speed
        drawn.append(place)
    return np.array(drawn)


def _hooked(dense: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Where the pen is set down and lifted it slips."""
    for end in (0, -1):
        if generator.random() < 0.3:
            angle = generator.uniform(0, 2 * np.pi)
            slip = dense[end] + generator.uniform(0.01, 0.04) * np.array([np.cos(angle), np.sin(angle)])
            dense = np.concatenate([slip[None], dense] if end == 0 else [dense, slip[None]])
    return dense


def _bezier(corners: np.ndarray, count: int = 60) -> np.ndarray:
    """A cubic Bezier curve (N, 2) of four points."""
    t = np.linspace(0, 1, count)[:, None]
    a, b, c, d = corners
    return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def _turned(shape: np.ndarray, angle: float) -> np.ndarray:
    return shape @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _bezier_line(generator: np.random.Generator) -> np.ndarray:
    """Straight lines, bows up to a U, waves, and profiles with a bump, in any direction."""
    kind = int(generator.integers(4))
    height = generator.uniform(-0.5, 0.5)
    if kind == 0:
        shape = np.array([[0, 0], [1, generator.normal(0, 0.03)]])
    elif kind == 1:
        depth = generator.uniform(-1.1, 1.1)
        shape = _bezier(np.array([[0, 0], [0.1, depth], [0.9, depth], [1, 0]]))
    elif kind == 2:
        shape = _bezier(np.array([[0, 0], [0.35, height], [0.65, -height], [1, 0]]))
    else:
        x = np.linspace(0, 1, 60)
        shape = np.stack([x, 0.6 * height * np.exp(-(((x - generator.uniform(0.3, 0.7)) / 0.18) ** 2))], 1)
    return _turned(shape, generator.uniform(0, 2 * np.pi))


def _loop_of_corners(generator: np.random.Generator) -> np.ndarray:
    """A closed line around something: a polygon whose corners are rounded as Chaikin rounds them."""
    count = int(generator.integers(4, 9))
    angles = (np.arange(count) + generator.uniform(-0.25, 0.25, count)) * 2 * np.pi / count
    corners = np.stack([np.cos(angles), generator.uniform(0.35, 1) * np.sin(angles)], 1)
    corners *= generator.uniform(0.75, 1.1, (count, 1))
    ring = _turned(corners, generator.uniform(0, 2 * np.pi))
    for _ in range(3):
        after = np.roll(ring, -1, axis=0)
        ring = np.stack([0.75 * ring + 0.25 * after, 0.25 * ring + 0.75 * after], 1).reshape(-1, 2)
    dense = resample(np.concatenate([ring, ring[:1]]), _DENSE)[:-1]
    start = int(generator.integers(len(dense)))
    longer = np.concatenate([np.roll(dense, -start, axis=0)] * 2)
    return longer[: int(len(dense) * generator.uniform(0.9, 1.1))]


def _bowed_arrow(generator: np.random.Generator) -> np.ndarray:
    """An arrow to the right whose barbs, and shaft where there is one, are bowed."""
    opening = np.radians(generator.uniform(25, 45))
    barbs = generator.uniform(0.8, 1.2, (2, 1)) * [[-np.cos(opening), np.sin(opening)]] * [[1, 1], [1, -1]]
    bows = generator.normal(0, 0.06, (3, 2))
    shaft = generator.random() < 0.5
    length = generator.uniform(1.8, 3) if shaft else 0.0
    tip = np.zeros(2)

    def bowed(a: np.ndarray, b: np.ndarray, bow: np.ndarray) -> np.ndarray:
        return _bezier(np.stack([a, a + (b - a) / 3 + bow, a + (b - a) * 2 / 3 + bow, b]), 20)

    parts = [bowed(barbs[0], tip, bows[0]), bowed(tip, barbs[1], bows[1])]
    if shaft:
        parts = [bowed(np.array([-length, 0.0]), tip, bows[2]), parts[0][::-1], *parts]
    return np.concatenate(parts)


def _loops(count: int, generator: np.random.Generator) -> np.ndarray:
    """A line to the right with whole ellipses above it (y up), one after the other."""
    width = generator.uniform(0.7, 1.2)
    height = generator.uniform(0.9, 2)
    lean = generator.normal(0, 0.2)
    gap = generator.uniform(0.5, 2.2)
    angles = np.linspace(-np.pi / 2, 1.5 * np.pi, 80)
    x = generator.uniform(-3.2, -1.2)
    parts = [_bezier(np.array([[x, generator.normal(0, 0.3)], [x * 0.6, 0], [x * 0.3, 0], [0, 0]]), 30)]
    for number in range(count):
        size = generator.uniform(0.8, 1.2)
        ellipse = size * np.stack([width * np.cos(angles), height * (np.sin(angles) + 1)], 1)
        parts.append(ellipse + np.outer(ellipse[:, 1], [lean, 0]) + [number * gap, generator.normal(0, 0.08)])
    x = (count - 1) * gap + generator.uniform(1.2, 3.2)
    inner = (count - 1) * gap
    end = np.array([[inner, 0], [inner + 0.4, 0], [x - 0.4, 0], [x, generator.normal(0, 0.3)]])
    return np.concatenate([*parts, _bezier(end, 30)])


def _lissajous(generator: np.random.Generator) -> np.ndarray:
    t = np.linspace(0, 2 * np.pi, 200)
    a, b = [(1, 2), (3, 2), (2, 3), (3, 4)][int(generator.integers(4))]
    return np.stack([np.sin(a * t + generator.uniform(0.3, 1.2)), np.sin(b * t)], 1)


def _hatching(generator: np.random.Generator) -> np.ndarray:
    count = int(generator.integers(6, 14))
    rows = np.stack([np.where(np.arange(count) % 2, 1.0, 0.0), np.arange(count) * generator.uniform(0.05, 0.2)], 1)
    return _turned(rows, generator.uniform(0, 2 * np.pi))


def _star(generator: np.random.Generator) -> np.ndarray:
    count = int(generator.choice([5, 7]))
    angles = np.arange(count + 1) * 2 * np.pi * (count // 2) / count + generator.uniform(0, 6)
    return np.stack([np.cos(angles), np.sin(angles)], 1)


def _letter(generator: np.random.Generator) -> np.ndarray:
    """Z, W, an ampersand or a two."""
    letters = (
        [[0, 0], [1, 0], [0, 1], [1, 1]],
        [[0, 0], [0.25, 1], [0.5, 0.3], [0.75, 1], [1, 0]],
        [[1, 1], [0.2, 0.2], [0.5, 0], [0.7, 0.2], [0, 0.8], [0.4, 1], [1, 0.5]],
        [[0, 0.3], [0.4, 0], [0.9, 0.2], [0.7, 0.6], [0, 1], [1, 1]],
    )
    return np.array(letters[int(generator.integers(len(letters)))], float)


_OTHERS = (_lissajous, _hatching, _star, _letter)
