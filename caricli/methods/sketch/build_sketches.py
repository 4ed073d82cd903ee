"""Sketches of a dataset's people."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.sketch_set import SketchWriter
from caricli.data.worker_pool import worker_pool
from caricli.io.image import gray_png
from caricli.methods.sketch.sketch_artist import ArtistSettings, SketchArtist
from caricli.methods.sketch.vary_sketch import HandSettings, hand_camera, vary_sketch
from caricli.methods.train.stages import Report, unwatched
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.seeds import SketchSeed
from caricli.structures.sketch import CANVAS, Sketch
from caricli.template.feature_curves import feature_curves
from caricli.template.template import Template

_UNIT = 8
"""Sketches that a worker draws at a time."""


@dataclass(frozen=True)
class SketchSettings:
    """count: sketches. side: pixels of the canvas. hand: how careless the hand is; 0 draws the exact lines, 1 as people
    do. seed: of everything random."""

    count: int
    side: int = CANVAS
    hand: float = 1.0
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Task:
    """Sketches that are drawn together. numbers: of them. rows: of their meshes. vertices: (n, V, 3) metres."""

    numbers: np.ndarray
    rows: np.ndarray
    vertices: np.ndarray


@dataclass(frozen=True, eq=False)
class Drawn:
    """A sketch, its picture as PNG, and what is known of it."""

    sketch: Sketch
    picture: bytes
    truth: dict[str, Any]


class SketchSource:
    """Draws sketches by their numbers; what all of them need is made once."""

    def __init__(self, template: Template, settings: SketchSettings) -> None:
        """template: Template of the dataset."""
        self.artist = SketchArtist(template, ArtistSettings(front=90.0))
        self.settings = settings
        self.hand = HandSettings().scaled(settings.hand)
        self.framed = np.unique(np.concatenate([curve.vertices for curve in self.artist.curves]))

    def draw(self, task: Task) -> list[Drawn]:
        """Draw the sketches of a task."""
        return [
            self._one(int(number), int(row), vertices.astype(np.float64))
            for number, row, vertices in zip(task.numbers, task.rows, task.vertices, strict=True)
        ]

    def _one(self, number: int, row: int, vertices: np.ndarray) -> Drawn:
        generator = np.random.default_rng([self.settings.seed, SketchSeed.SKETCH, number])
        side = self.settings.side
        camera = hand_camera(vertices[self.framed], side, generator, self.hand)
        exact = self.artist.draw(vertices, camera, (side, side))
        sketch = vary_sketch(exact, generator, self.hand) if self.settings.hand else exact
        truth = {
            "row": row,
            "rotation": camera.rotation,
            "scale": camera.scale,
            "translation": camera.translation,
        }
        return Drawn(sketch, gray_png(255 - rasterise_sketch(sketch, side)), truth)


def build_sketches(
    writer: Callable[[tuple[str, ...]], SketchWriter],
    dataset: Dataset,
    settings: SketchSettings,
    workers: int | None = None,
    progress: Report = unwatched,
) -> dict[str, float]:
    """Draw sketches of the meshes of a dataset, each as often as the next. The same settings give the same bytes,
    whatever the number of workers.

    writer: gives the SketchWriter of an empty folder for names of curves. workers: processes; None for one per usable
    core. progress: called with the number of sketches and their total.
    Returns how many sketches there are, and their strokes in the mean.
    """
    make = partial(SketchSource, dataset.template, settings)
    folder = writer(tuple(curve.name for curve in feature_curves(dataset.template.annotation)))
    strokes = 0
    with worker_pool(workers, make) as run:
        for unit in run(SketchSource.draw, _tasks(dataset, settings)):
            for drawn in unit:
                folder.add(drawn.sketch, drawn.picture, drawn.truth | _labels(dataset, drawn.truth["row"]))
                strokes += len(drawn.sketch.strokes)
                progress(folder.count, settings.count)
    folder.finish(
        {
            "settings": asdict(settings),
            "side": settings.side,
            "hand": asdict(HandSettings().scaled(settings.hand)),
            "artist": asdict(ArtistSettings(front=90.0)),
            "topology_id": dataset.template.topology_id,
            "splits": dataset.manifest["splits"],
        }
    )
    return {"sketches": folder.count, "strokes": strokes / max(folder.count, 1)}


def _labels(dataset: Dataset, row: int) -> Mapping[str, Any]:
    columns = {"person": dataset.identity, "expression": dataset.expression, "level": dataset.level}
    return {name: int(column[row]) for name, column in columns.items()}


def _tasks(dataset: Dataset, settings: SketchSettings) -> Iterator[Task]:
    """Units of work: the meshes in a random order, again and again."""
    generator = np.random.default_rng([settings.seed, SketchSeed.ORDER])
    count = len(dataset.vertices)
    rounds = -(-settings.count // count)
    rows = np.concatenate([generator.permutation(count) for _ in range(rounds)])[: settings.count]
    for start in range(0, settings.count, _UNIT):
        chosen = rows[start : start + _UNIT]
        yield Task(np.arange(start, start + len(chosen)), chosen, dataset.vertices[chosen])
