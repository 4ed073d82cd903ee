"""Sketches as many hands would draw them."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.deformation.move_by_handles import move_by_handles
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.structures.camera import Camera
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

_STEP = 3.0
"""Pixels between the points of a drawn line, about."""


@dataclass(frozen=True)
class HandSettings:
    """How a hand departs from the exact lines. Lengths are shares of the canvas's side; chances from 0 to 1.

    view: standard deviations of yaw, pitch and roll, degrees. fill: longer side of what is drawn, least and greatest.
    aside: of the middle, at most, as far as the canvas has room.
    removed: shares of the strokes that are left out, one of them by chance (Yu et al. 2016). late, short: how much
    more likely later and shorter strokes are left out. bare: chance that no wrinkle is drawn.
    bend: of the handles of the whole sketch, moved by chance. strays: of a stroke as a whole; turn: degrees that it
    turns; grow: by which it grows; wobble: of its course; tremor: of its points.
    overshot, gap, doubled: chances for a stroke; over: of an overshoot, longest; hole: of a gap, longest; beside: how
    far the second line strays. pressed: chance that a sketch shows pressure. light: least pressure. width: of lines, in
    pixels of a canvas of 256.
    """

    view: tuple[float, float, float] = (5.0, 4.0, 3.0)
    fill: tuple[float, float] = (0.62, 0.94)
    aside: float = 0.08
    removed: tuple[float, ...] = (0.0, 0.0, 0.1, 0.3, 0.5)
    late: float = 0.5
    short: float = 0.5
    bare: float = 0.15
    bend: float = 0.012
    strays: float = 0.004
    turn: float = 1.5
    grow: float = 0.02
    wobble: float = 0.004
    tremor: float = 0.0008
    overshot: float = 0.25
    over: float = 0.03
    gap: float = 0.15
    hole: float = 0.035
    doubled: float = 0.15
    beside: float = 0.008
    pressed: float = 0.6
    light: float = 0.35
    width: tuple[float, float] = (1.0, 3.2)

    def scaled(self, strength: float) -> "HandSettings":
        """The same hand, so many times as careless; 0 draws the lines centred, without their finest corners."""
        amounts = ("bend", "strays", "turn", "grow", "wobble", "tremor", "over", "hole", "beside", "aside")
        chances = ("bare", "overshot", "gap", "doubled", "pressed")
        values = {name: strength * getattr(self, name) for name in amounts}
        values |= {name: min(strength * getattr(self, name), 1.0) for name in chances}
        middle = sum(self.fill) / 2
        least, greatest = (float(np.clip(middle + strength * (share - middle), 0.4, 0.98)) for share in self.fill)
        yaw, pitch, roll = (strength * angle for angle in self.view)
        return replace(
            self,
            **values,
            view=(yaw, pitch, roll),
            fill=(least, greatest),
            removed=tuple(min(strength * share, 0.8) for share in self.removed),
            width=self.width if strength else (1.0, 1.0),
        )


def hand_camera(points: np.ndarray, side: int, generator: np.random.Generator, settings: HandSettings) -> Camera:
    """A camera that sees points (N, 3) about from the front, about in the middle of a square canvas of side pixels."""
    angles = np.radians(np.array(settings.view) * np.clip(generator.normal(size=3), -2.5, 2.5))
    rotation = head_rotation(angles[[1, 0, 2]])
    flat = points @ rotation[:2].T
    fill = generator.uniform(*settings.fill)
    scale = fill * side / max(np.ptp(flat, axis=0).max(), 1e-6)
    room = min(settings.aside, (1 - fill) / 2 + 0.02)
    middle = (side - 1) / 2 + side * room * generator.uniform(-1, 1, 2)
    return Camera(float(scale), rotation, middle - scale * (flat.min(0) + flat.max(0)) / 2)


def vary_sketch(sketch: Sketch, generator: np.random.Generator, settings: HandSettings | None = None) -> Sketch:
    """A sketch as a hand draws it: lines left out (by length and order, Yu et al. 2016), bent as a whole and one by
    one, overshot, broken, doubled, with tremor, pressure and some width.

    sketch: exact, in the order in which it would be drawn. A curve's name stays with a line that draws all of it.
    Returns Sketch; at least one stroke is left.
    """
    settings = settings or HandSettings()
    side = max(sketch.size)
    strokes = list(sketch.strokes)
    if generator.random() < settings.bare:
        strokes = [stroke for stroke in strokes if stroke.kind is not StrokeKind.WRINKLE] or strokes
    strokes = _without_some(strokes, generator, settings)
    lines = [stroke.moved_to(_sampled(stroke.points, _STEP * side / 256)) for stroke in strokes]
    lines = _bent(lines, side, generator, settings)
    width = float(generator.uniform(*settings.width)) * side / 256
    presses = generator.random() < settings.pressed
    drawn: list[Stroke] = []
    for line in lines:
        moved = line.moved(_strayed(line.points, side, generator, settings, 1.0))
        again = generator.random() < settings.doubled
        drawn += _broken(_overshot(moved, side, generator, settings), side, generator, settings)
        if again:
            share = settings.beside / max(settings.strays, 1e-9)
            second = _strayed(line.points, side, generator, settings, share)
            drawn.append(replace(line, points=second, curve=None))
    return sketch.with_strokes(
        replace(stroke, width=width, pressure=_pressure(stroke, generator, settings) if presses else None)
        for stroke in drawn
    )


def _without_some(strokes: list[Stroke], generator: np.random.Generator, settings: HandSettings) -> list[Stroke]:
    share = settings.removed[generator.integers(len(settings.removed))]
    count = min(round(share * len(strokes)), len(strokes) - 1)
    if count <= 0:
        return strokes
    order = np.linspace(0, 1, len(strokes))
    length = np.array([stroke.length for stroke in strokes])
    length = length / max(length.max(), 1e-9)
    # Equation 1 of Yu et al.: exp(late * order) / exp(short * length), with both counted in standard deviations.
    score = settings.late * _standard(order) - settings.short * _standard(length)
    chance = np.exp(score - score.max())
    gone = set(generator.choice(len(strokes), count, replace=False, p=chance / chance.sum()).tolist())
    return [stroke for number, stroke in enumerate(strokes) if number not in gone]


def _standard(values: np.ndarray) -> np.ndarray:
    return (values - values.mean()) / max(float(values.std()), 1e-9)


def _bent(lines: list[Stroke], side: int, generator: np.random.Generator, settings: HandSettings) -> list[Stroke]:
    """All lines after one smooth deformation, by handles around and inside of them."""
    points = np.concatenate([line.points for line in lines])
    low = points.min(0)
    extent = np.maximum(np.ptp(points, axis=0), 1e-3 * side)
    handles = low + extent * np.stack(np.meshgrid([0, 0.5, 1], [0, 0.5, 1]), -1).reshape(-1, 2)
    moved = move_by_handles(points, handles, handles + settings.bend * side * generator.normal(size=handles.shape))
    ends = np.cumsum([len(line.points) for line in lines])[:-1]
    return [line.moved(part) for line, part in zip(lines, np.split(moved, ends), strict=True)]


def _strayed(
    points: np.ndarray, side: int, generator: np.random.Generator, settings: HandSettings, share: float
) -> np.ndarray:
    """A line that was drawn beside itself: moved, turned and grown as a whole, wobbling, with tremor."""
    count = len(points)
    middle = points.mean(0)
    angle = np.radians(settings.turn) * generator.normal()
    size = 1 + settings.grow * generator.normal()
    turn = size * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    aside = share * settings.strays * side * generator.normal(size=2)
    along = np.linspace(0, 1, count)[:, None]
    wobble = np.zeros((count, 2))
    for wave in (1, 2, 3):
        phase = generator.uniform(0, 2 * np.pi, 2)
        # Whole waves, so that a closed line stays closed.
        wobble += generator.normal(size=2) * np.sin(2 * np.pi * wave * along + phase) / wave
    tremor = settings.tremor * side * generator.normal(size=(count, 2))
    strayed = (points - middle) @ turn.T + middle + aside + settings.wobble * side * wobble / 1.5 + tremor
    if count > 2 and (points[0] == points[-1]).all():
        strayed[-1] = strayed[0]
    return strayed


def _overshot(stroke: Stroke, side: int, generator: np.random.Generator, settings: HandSettings) -> Stroke:
    """A line that goes on beyond its end, or its start."""
    points = stroke.points
    for at_end in (False, True):
        if generator.random() < settings.overshot and len(points) > 2:
            inner, tip = (points[-3], points[-1]) if at_end else (points[2], points[0])
            way = (tip - inner) / max(float(np.linalg.norm(tip - inner)), 1e-9)
            further = tip + way * settings.over * side * generator.uniform(0.2, 1)
            points = np.vstack([points, further]) if at_end else np.vstack([further, points])
    return stroke.moved_to(points)


def _broken(stroke: Stroke, side: int, generator: np.random.Generator, settings: HandSettings) -> list[Stroke]:
    """A line with a gap, or as it is."""
    hole = round(settings.hole * side * generator.uniform(0.3, 1) / (_STEP * side / 256))
    if generator.random() >= settings.gap or len(stroke.points) < hole + 8:
        return [stroke]
    start = int(generator.integers(3, len(stroke.points) - hole - 3))
    first, second = stroke.points[: start + 1], stroke.points[start + 1 + hole :]
    return [replace(stroke, points=part, curve=None) for part in (first, second)]


def _pressure(stroke: Stroke, generator: np.random.Generator, settings: HandSettings) -> np.ndarray:
    """(N,) light at the ends, with a slow change in between."""
    along = np.linspace(0, 1, len(stroke.points))
    wave = np.sin(2 * np.pi * (generator.uniform(0.3, 1.2) * along + generator.uniform()))
    body = generator.uniform(0.6, 1) + 0.15 * wave
    ends = np.clip(np.minimum(along, 1 - along) / generator.uniform(0.03, 0.2), 0.4, 1)
    return np.clip(body * ends, settings.light, 1)


def _sampled(points: np.ndarray, step: float) -> np.ndarray:
    """Points (M, 2) along a line (N, 2), about a step apart, without the corners of a coarse one."""
    along = arc_lengths(points)
    if along[-1] <= 0:
        return points[:1]
    places = np.linspace(0, along[-1], max(int(np.ceil(along[-1] / step)), 2) + 1)
    sampled = np.column_stack([np.interp(places, along, points[:, axis]) for axis in (0, 1)])
    for _ in range(2):
        inner = (sampled[:-2] + 2 * sampled[1:-1] + sampled[2:]) / 4
        sampled = np.vstack([sampled[:1], inner, sampled[-1:]])
    return sampled
