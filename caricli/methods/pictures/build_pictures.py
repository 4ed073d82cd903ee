"""Pictures with truth for a whole dataset."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.picture_set import PictureWriter, encode_labels, encode_picture
from caricli.data.unseen import people_entry
from caricli.data.worker_pool import worker_pool
from caricli.geometry.alignment.head_rotation import head_angles
from caricli.methods.pictures.compose import Composition, Easel, Shown
from caricli.methods.pictures.settings import PoseSettings, SceneSettings, SitterSettings
from caricli.methods.pictures.sitter import Sitter, Wardrobe
from caricli.methods.train.stages import Report, unwatched
from caricli.models.morphable.model import MorphableModel
from caricli.seeds import PictureSeed
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class Task:
    """One unit of work: a few people, and pictures of them.

    number: of the unit. rows: (K,) of the dataset. vertices: (K, V, 3) metres. count: pictures.
    """

    number: int
    rows: np.ndarray
    vertices: np.ndarray
    count: int


@dataclass(frozen=True, eq=False)
class Finished:
    """A picture in its files' bytes; faces: rows of the truth, ``row`` that of the dataset."""

    image: bytes
    labels: bytes
    medium: str
    faces: list[dict[str, Any]]


class PictureSource:
    """Draws units of work; prepared once in every process."""

    def __init__(self, template: Template, model: MorphableModel, size: int, seed: int) -> None:
        """template: of the faces. model: whose coefficients are written. size: pixels. seed: of everything random."""
        self.model = model
        self.seed = seed
        self.wardrobe = Wardrobe(template)
        self.easel = Easel(size)

    def draw(self, task: Task) -> list[Finished]:
        """Draw the pictures of a unit."""
        generators = [
            np.random.default_rng([self.seed, PictureSeed.SITTER, task.number, place])
            for place in range(len(task.rows))
        ]
        faces = zip(task.vertices.astype(float), generators, strict=True)
        sitters = [self.wardrobe.seat(vertices, generator) for vertices, generator in faces]
        codes = [self._code(sitter) for sitter in sitters]
        pictures = []
        for place in range(task.count):
            generator = np.random.default_rng([self.seed, PictureSeed.PICTURE, task.number, place])
            picture = self.easel.compose(sitters, place % len(sitters), generator)
            pictures.append(_finished(picture, task.rows, codes))
        return pictures

    def _code(self, sitter: Sitter) -> np.ndarray:
        """Identity, expression and albedo of a sitter in the morphable model."""
        model = self.model
        basis = model.albedo.basis.reshape(len(model.albedo.basis), -1)
        colours = sitter.albedo - model.albedo.mean
        # The components are orthogonal.
        albedo = basis @ colours.ravel() / np.maximum((basis**2).sum(1), 1e-12)
        return np.concatenate([model.encode(sitter.skin.vertices[None])[0], albedo])


@dataclass(frozen=True)
class PictureSettings:
    """count: pictures. size: pixels, width and height. seed: of everything random."""

    count: int
    size: int = 256
    seed: int = 0


def build_pictures(
    writer: PictureWriter,
    dataset: Dataset,
    model: MorphableModel,
    settings: PictureSettings,
    workers: int | None = None,
    progress: Report = unwatched,
) -> dict[str, int]:
    """Draw pictures of the people of a dataset. The same settings give the same bytes, whatever the number of workers.

    writer: of an empty folder. model: MorphableModel of the dataset's topology, whose coefficients are written.
    workers: processes; None for one per usable core. progress: called with the number of pictures and their total.
    Returns how many pictures and faces there are.
    """
    make = partial(PictureSource, dataset.template, model, settings.size, settings.seed)
    faces = 0
    with worker_pool(workers, make) as run:
        for unit in run(PictureSource.draw, drawing_tasks(dataset, settings)):
            for picture in unit:
                rows = [face.pop("row") for face in picture.faces]
                labels = [
                    {
                        "person": dataset.identity[row],
                        "expression": dataset.expression[row],
                        "level": dataset.level[row],
                    }
                    for row in rows
                ]
                together = [{**face, **label} for face, label in zip(picture.faces, labels, strict=True)]
                writer.add(picture.image, picture.labels, picture.medium, together)
                faces += len(together)
                progress(writer.count, settings.count)
    writer.finish(
        {
            "settings": asdict(settings),
            "scene": asdict(SceneSettings()),
            "pose": asdict(PoseSettings()),
            "sitter": asdict(SitterSettings()),
            "topology_id": dataset.template.topology_id,
            "model_id": model.model_id,
            "splits": dataset.manifest["splits"],
        }
        | people_entry(dataset)
    )
    return {"pictures": writer.count, "faces": faces}


def drawing_tasks(dataset: Dataset, settings: PictureSettings) -> Iterator[Task]:
    """Units of work; people of one split are together, so that no picture shows people of two."""
    scene = SceneSettings()
    generator = np.random.default_rng([settings.seed, PictureSeed.ORDER])
    units: list[np.ndarray] = []
    while len(units) * scene.pictures < settings.count:
        for split in dataset.manifest["splits"]:
            rows = generator.permutation(np.flatnonzero(dataset.rows(split)))
            units += [rows[start : start + scene.sitters] for start in range(0, len(rows), scene.sitters)]
    units = [units[k] for k in generator.permutation(len(units))]
    left = settings.count
    for number, rows in enumerate(units):
        if left <= 0:
            return
        count = min(scene.pictures, left)
        left -= count
        yield Task(number, rows, dataset.vertices[rows], count)


def _finished(picture: Composition, rows: np.ndarray, codes: list[np.ndarray]) -> Finished:
    faces = [_row(face, codes[face.sitter]) | {"row": int(rows[face.sitter])} for face in picture.faces]
    return Finished(encode_picture(picture.image), encode_labels(picture.region), picture.medium, faces)


def _row(face: Shown, code: np.ndarray) -> dict[str, Any]:
    pose = np.concatenate([head_angles(face.rotation), face.translation, [face.scale]])
    return {
        "landmarks": face.points,
        "visible": face.visible,
        "rotation": face.rotation,
        "scale": face.scale,
        "translation": face.translation,
        "perspective": face.perspective,
        "light": face.light,
        "coefficients": np.concatenate([code, face.light.mean(1), pose]),
    }
