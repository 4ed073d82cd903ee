"""The shapes of those who sat for pictures: what no folder of pictures stores, but its seed and its dataset repeat."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from caricli.data.appearance import Appearance, random_appearance
from caricli.data.dataset import Dataset
from caricli.data.picture_set import PictureSet
from caricli.errors import InputError
from caricli.methods.pictures.build_pictures import PictureSettings, Task, drawing_tasks
from caricli.methods.pictures.mime import is_usual_head, random_mime
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.settings import SitterSettings
from caricli.seeds import PictureSeed
from caricli.structures.landmarks import COUNT, JAW

_APART = 0.5
"""Pixels between a landmark of the pictures and the vertex that it stands on, beyond which it is another face."""


@dataclass(frozen=True, eq=False)
class SitterShapes:
    """Who is in the pictures of a PictureSet.

    vertices: (K, V, 3) float32, metres, faces with all that they do. appearances: K of them, how they look. places:
    (M,) int, which of them a row of the truth shows.
    """

    vertices: np.ndarray
    appearances: list[Appearance]
    places: np.ndarray


def sitter_shapes(pictures: PictureSet, dataset: Dataset) -> SitterShapes:
    """Repeat what was drawn at random of the people of a dataset when pictures of them were made.

    Every landmark but those of the jaw, which slides, is compared with its vertex before the stored camera.
    Raises InputError where they differ: the pictures are of other people, or of another version.
    """
    truth = pictures.truth
    settings = _settings(pictures.manifest)
    mimes = _mimes(pictures.manifest)
    usual = is_usual_head(dataset.template)
    shapes: list[np.ndarray] = []
    appearances: list[Appearance] = []
    places = np.zeros(len(truth["picture"]), int)
    first = 0
    for task in drawing_tasks(dataset, settings):
        own = np.flatnonzero((truth["picture"] >= first) & (truth["picture"] < first + task.count))
        first += task.count
        for row in own:
            places[row] = len(shapes) + _sitter(task, dataset, [int(truth[n][row]) for n in _NAMES])
        for place, vertices in enumerate(task.vertices.astype(float)):
            generator = np.random.default_rng([settings.seed, PictureSeed.SITTER, task.number, place])
            appearances.append(random_appearance(generator))
            moved = random_mime(vertices, dataset.template, mimes, generator) if usual else 0
            shapes.append((vertices + moved).astype(np.float32))
    result = SitterShapes(np.stack(shapes), appearances, places)
    _check(result, pictures, dataset)
    return result


_NAMES = ("person", "expression", "level")
_MIMES = {"twisted": 0.0, "grinning": 0.0, "laughing": 0.0, "loudest": 1.5, "widest": 0.6, "wide": 0.0}
"""What sitters did in pictures that do not tell it: the first ones did not grin, and the next did not laugh."""


def _settings(manifest: dict[str, Any]) -> PictureSettings:
    value = manifest.get("settings")
    names = [field.name for field in fields(PictureSettings)]
    if not isinstance(value, dict) or not all(type(value.get(name)) is int for name in names):
        raise InputError(f"expected pictures with their settings {', '.join(names)}, found others")
    return PictureSettings(**{name: value[name] for name in names})


def _mimes(manifest: dict[str, Any]) -> SitterSettings:
    value = manifest.get("sitter")
    own: dict[str, Any] = value if isinstance(value, dict) else dict.fromkeys(_MIMES)
    numbers = {name: own.get(name, usual) for name, usual in _MIMES.items()}
    if not all(isinstance(number, int | float) for number in numbers.values()):
        raise InputError("expected pictures with the chances of what their sitters do, found others")
    return replace(SitterSettings(), **numbers)


def _sitter(task: Task, dataset: Dataset, labels: list[int]) -> int:
    """Which of a task's people has the labels of _NAMES."""
    for place, row in enumerate(task.rows):
        if labels == [dataset.identity[row], dataset.expression[row], dataset.level[row]]:
            return place
    raise InputError("expected pictures of this dataset, found one of others")


def _check(shapes: SitterShapes, pictures: PictureSet, dataset: Dataset) -> None:
    truth = pictures.truth
    marks = dataset.template.annotation.landmarks[len(JAW) : COUNT]
    for row, place in enumerate(shapes.places):
        vertices = shapes.vertices[place].astype(float)
        pose = Pose(
            truth["rotation"][row],
            float(truth["scale"][row]),
            truth["translation"][row],
            float(truth["perspective"][row]),
            vertices.mean(0),
            float(np.ptp(vertices[:, 1])),
        )
        gaps = pose.place(vertices[marks])[:, :2] - truth["landmarks"][row, len(JAW) : COUNT]
        if np.abs(gaps).max() > _APART:
            raise InputError(
                "expected pictures of this dataset, found landmarks that are not where its faces have them"
            )
