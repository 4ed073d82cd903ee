"""Drawings photographed by a phone: what of their lines is read.

Usage: python -m benchmarks.photographed_sketches DATASET [COUNT [WAY...]]. The drawings are lines of a hand (moved,
bent, some left out) of COUNT (default: 60) faces of a dataset, from the front, in ink or pencil. Each is photographed
in every WAY (default: all); shadows fall anywhere, over the drawing, too. Figures are means over the drawings: percent
of the drawn length within 1.5 % of the drawing's longer side of what is read, and of what is read of what was drawn; a
drawing that is refused counts as nothing, and one is spoilt where either is less than 90 %; and how many strokes are
read for one that was drawn. The last line is JSON.
"""

import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial import KDTree

from caricli.data.dataset import read_dataset
from caricli.errors import InputError
from caricli.methods.sketch.clean_drawing import clean_drawing
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.vary_sketch import vary_sketch
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.store.models import load_model
from caricli.structures.sketch import Sketch, Stroke
from caricli.template.feature_curves import named_curves

SIDE = 900
"""Pixels of the paper."""
NEAR = 0.015
"""Of the drawing's longer side: lines so near are the same."""
SPOILT = 0.9
"""Share of a drawing that is read, or of what is read that was drawn, at least."""


class Photograph:
    """A sheet of paper (SIDE, SIDE, 3) from 0 to 1, what happens to it, and where it lies in the picture.

    place: (3, 3), from pixels of the paper to those of the picture.
    """

    def __init__(self, ink: np.ndarray, generator: np.random.Generator) -> None:
        """ink: (SIDE, SIDE) from 0 to 1, on paper in the light of a window."""
        self._generator = generator
        self.quality = int(generator.integers(65, 92))
        self.place = np.eye(3)
        angle = generator.uniform(0, 2 * np.pi)
        y, x = np.mgrid[:SIDE, :SIDE] / SIDE - 0.5
        light = 0.85 - generator.uniform(0.05, 0.3) * (np.cos(angle) * x + np.sin(angle) * y)
        paper = np.array([0.9, 0.97, 1.0]) ** generator.uniform(0, 1.5)
        self.pixels = (light * (1 - generator.uniform(0.4, 0.85) * ink))[..., None] * paper

    def darken(self, mask: np.ndarray, least: float, most: float) -> None:
        """Take a share of the light where a mask (H, W) from 0 to 1 says."""
        self.pixels = self.pixels * (1 - self._generator.uniform(least, most) * mask)[..., None]

    def shade(self, softest: float, sharpest: float) -> None:
        """The shadow of a hand or a phone that comes in from a side. softest, sharpest: pixels of its border."""
        draw = self._generator
        height, width = self.pixels.shape[:2]
        reach = draw.uniform(0.5, 0.9) * max(height, width)
        angle = draw.uniform(0, 2 * np.pi)
        middle = (
            np.array([width, height]) / 2 + np.array([np.cos(angle), np.sin(angle)]) * draw.uniform(0.4, 0.65) * width
        )
        mask = np.zeros((height, width), np.uint8)
        if draw.uniform() < 0.5:
            box = (middle.tolist(), (reach, reach * draw.uniform(1.2, 2)), draw.uniform(0, 180))
            cv2.fillConvexPoly(mask, np.round(cv2.boxPoints(box)).astype(int), 255)
        else:
            axes = (int(0.5 * reach), int(0.4 * reach))
            cv2.ellipse(mask, _pixel(middle), axes, draw.uniform(0, 180), 0, 360, 255, -1)
            for turn in draw.normal(np.pi, 0.35, 4):
                way = np.array([np.cos(angle + turn), np.sin(angle + turn)])
                tip = middle + way * reach * draw.uniform(0.6, 0.95)
                cv2.line(mask, _pixel(middle), _pixel(tip), 255, int(0.09 * max(height, width)))
        self.darken(cv2.GaussianBlur(mask / 255, (0, 0), draw.uniform(sharpest, softest)), 0.25, 0.6)

    def fold(self) -> None:
        """One or two folds of the paper: its sides are in other light, and its edge is worn."""
        draw = self._generator
        y, x = np.mgrid[:SIDE, :SIDE] - SIDE / 2
        for angle in draw.uniform(0, np.pi, draw.integers(1, 3)):
            away = x * np.cos(angle) + y * np.sin(angle) - draw.normal(0, 0.15) * SIDE
            self.darken((1 + draw.choice([-1, 1]) * np.tanh(away / 6)) / 2, 0.05, 0.18)
            self.darken(np.exp(-((away / 1.5) ** 2)), 0.05, 0.2)

    def smudge(self) -> None:
        """Graphite that a hand has rubbed over the paper."""
        draw = self._generator
        for _ in range(draw.integers(3, 8)):
            mask = np.zeros((SIDE, SIDE))
            axes = (int(draw.uniform(20, 90)), int(draw.uniform(8, 30)))
            cv2.ellipse(mask, _pixel(draw.uniform(0.15, 0.85, 2) * SIDE), axes, draw.uniform(0, 180), 0, 360, 1, -1)
            self.darken(cv2.GaussianBlur(mask, (0, 0), draw.uniform(6, 20)), 0.08, 0.22)

    def lay_on_table(self) -> None:
        """The paper on a table with a grain, seen from aside; it throws a shadow."""
        draw = self._generator
        border = int(draw.uniform(60, 160))
        side = SIDE + 2 * border
        corners = np.array([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE]], np.float32)
        moved = corners + border + np.clip(draw.normal(0, 0.045 * SIDE, (4, 2)), -0.8 * border, 0.8 * border)
        self.place = cv2.getPerspectiveTransform(corners, moved.astype(np.float32))
        grain = cv2.GaussianBlur(draw.normal(0, 1, (side, side)), (0, 0), sigmaX=30, sigmaY=2)
        colour = draw.uniform(0.12, 0.6) * np.array([0.8, 0.9, 1.0]) ** draw.uniform(-1, 1.5)
        table = np.clip(colour + 0.03 * (grain / grain.std())[..., None], 0, 1)
        covered = cv2.warpPerspective(np.ones((SIDE, SIDE)), self.place, (side, side))[..., None]
        below = cv2.GaussianBlur(np.roll(covered[..., 0], 8, 0), (0, 0), 8)[..., None]
        paper = cv2.warpPerspective(self.pixels, self.place, (side, side), flags=cv2.INTER_AREA)
        self.pixels = table * (1 - 0.4 * below) * (1 - covered) + paper * covered

    def shake(self) -> None:
        """A poor camera in a hand that moves."""
        self.pixels = cv2.resize(self.pixels, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        self.place = np.diag([0.5, 0.5, 1]) @ self.place
        way = np.zeros((5, 5))
        cv2.line(way, (0, 2), (4, int(self._generator.integers(0, 5))), 1)
        self.pixels = cv2.filter2D(self.pixels, -1, way / way.sum())
        self.quality = 40

    def taken(self) -> np.ndarray:
        """(H, W, 3) uint8: through a lens, with noise and the paper's grain, as JPEG."""
        draw = self._generator
        pixels = cv2.GaussianBlur(self.pixels, (0, 0), draw.uniform(0.6, 1.2))
        noise = draw.normal(0, draw.uniform(0.006, 0.02), pixels.shape[:2])
        grain = cv2.GaussianBlur(draw.normal(0, 0.03, pixels.shape[:2]), (0, 0), 2)
        levels = np.round(255 * np.clip(pixels + (noise + grain)[..., None], 0, 1)).astype(np.uint8)
        jpeg = cv2.imencode(".jpg", levels, [cv2.IMWRITE_JPEG_QUALITY, self.quality])[1]
        return cv2.imdecode(jpeg, cv2.IMREAD_COLOR)


def poor_camera(photograph: Photograph) -> None:
    """On a table, and not held still."""
    photograph.lay_on_table()
    photograph.shake()


WAYS: dict[str, Callable[[Photograph], None]] = {
    "even light": lambda photograph: None,
    "on a table, from aside": Photograph.lay_on_table,
    "a hard shadow": partial(Photograph.shade, softest=4, sharpest=0.8),
    "a soft shadow": partial(Photograph.shade, softest=35, sharpest=10),
    "folded paper": Photograph.fold,
    "smudges": Photograph.smudge,
    "every line two or three times": lambda photograph: None,
    "a poor camera": poor_camera,
}
REPEATED = "every line two or three times"


def _pixel(point: np.ndarray) -> tuple[int, int]:
    return tuple(np.round(point).astype(int).tolist())


def searched(sketch: Sketch, generator: np.random.Generator) -> Sketch:
    """A sketch whose lines were searched for: each is two or three paler ones, up to some 2 % of the canvas apart."""
    strokes = []
    for stroke in sketch.strokes:
        count = len(stroke.points)
        away = min(0.05 * float(np.ptp(stroke.points, axis=0).max()), 0.008 * max(sketch.size))
        for _ in range(generator.integers(2, 4)):
            first = generator.integers(0, count // 4 + 1)
            points = stroke.points[first : count - generator.integers(0, count // 4 + 1)]
            t = np.linspace(0, 1, len(points))[:, None]
            bends = [
                generator.normal(0, away / k, 2) * np.sin(np.pi * (k * t + generator.uniform(0, 2))) for k in (1, 2)
            ]
            moved = points + sum(bends) + generator.normal(0, 0.5 * away, 2)
            strokes.append(Stroke(moved, pressure=np.full(len(points), generator.uniform(0.6, 1))))
    return sketch.with_strokes(strokes)


def photographed(sketch: Sketch, way: str, generator: np.random.Generator) -> tuple[np.ndarray, list[np.ndarray]]:
    """A picture (H, W, 3) uint8 of a sketch, and where its lines (N, 2) are in it."""
    drawn = searched(sketch, generator) if way == REPEATED else sketch
    photograph = Photograph(rasterise_sketch(drawn, SIDE, generator.uniform(1.6, 4)) / 255, generator)
    WAYS[way](photograph)
    zoom = SIDE / max(sketch.size)
    on_paper = [(stroke.points + 0.5) * zoom - 0.5 for stroke in sketch.strokes]
    lines = [cv2.perspectiveTransform(points[None], photograph.place)[0] for points in on_paper]
    return photograph.taken(), lines


def shares(drawn: list[np.ndarray], read: list[np.ndarray]) -> tuple[float, float]:
    """Of lines (N, 2), in boxes of their own: the share of the drawn ones that was read, and the other way round."""
    points = [_dense(lines) for lines in (drawn, read)]
    boxed = [(each - each.min(0)) / np.ptp(each, axis=0).max() for each in points]
    first, second = (KDTree(boxed[1]).query(boxed[0])[0], KDTree(boxed[0]).query(boxed[1])[0])
    return float((first < NEAR).mean()), float((second < NEAR).mean())


def _dense(lines: list[np.ndarray]) -> np.ndarray:
    pieces = [np.linspace(line[:-1], line[1:], 6).reshape(-1, 2) for line in lines]
    return np.concatenate(pieces)


def judged(image: np.ndarray, lines: list[np.ndarray]) -> dict[str, float]:
    """What of a photographed sketch is read, in percent."""
    try:
        sketch = clean_drawing(image)
    except InputError:
        return {"refused": 100.0, "read": 0.0, "drawn": 0.0, "spoilt": 100.0, "strokes": np.nan}
    read, drawn = shares(lines, [stroke.points for stroke in sketch.strokes])
    figures = {"refused": 0.0, "read": 100 * read, "drawn": 100 * drawn, "strokes": len(sketch.strokes) / len(lines)}
    return figures | {"spoilt": 100.0 * (min(read, drawn) < SPOILT)}


def main(dataset, count=60, *ways):
    """Print the table."""
    curves = named_curves(load_model().template.annotation)
    faces = read_dataset(Path(dataset)).vertices
    chosen = np.linspace(0, len(faces) - 1, int(count)).astype(int)
    rows = []
    for way in ways or WAYS:
        figures = []
        for row in chosen:
            face = np.asarray(faces[row], float)
            hand = vary_sketch(draw_sketch(face, curves, canvas_camera(face, curves)), np.random.default_rng(int(row)))
            drawing = photographed(hand, way, np.random.default_rng([int(row), [*WAYS].index(way)]))
            figures.append(judged(*drawing))
        mean = {key: float(np.nanmean([each[key] for each in figures])) for key in figures[0]}
        rows.append({"name": way} | mean)
        print(f"{way:30}", {key: round(value, 2) for key, value in mean.items()}, flush=True)
    print(json.dumps({"photographs": rows}))


if __name__ == "__main__":
    main(*sys.argv[1:])
