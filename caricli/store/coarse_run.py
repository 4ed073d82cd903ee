"""The training of a coarse network in its folder."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from caricli.data.dataset import Dataset, read_dataset
from caricli.data.picture_set import MANIFEST, read_picture_set
from caricli.data.unseen import everybody
from caricli.errors import CaricliError, InputError, naming, shown
from caricli.io.image import read_image
from caricli.io.provenance import sha256_file, sha256_files
from caricli.methods.detect.see_face import see_face
from caricli.methods.train.coarse.coarse_faces import JoinedFaces, StudiedFace, TrueFaces
from caricli.methods.train.coarse.train_coarse import CoarseTraining, Sources
from caricli.methods.train.stages import Report, unwatched
from caricli.models.coarse.model import LANDMARKS, CoarseModel, coarse_to_checkpoint
from caricli.models.detector.model import Detector
from caricli.models.morphable.model import MorphableModel
from caricli.store.coarse import load_coarse
from caricli.store.datasets import is_picture_set
from caricli.store.detector import load_detector
from caricli.store.models import load_morphable
from caricli.store.pictures import pictures_in
from caricli.store.training_run import RunFolder
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.parsing import BEYOND


@dataclass(frozen=True)
class SeenPicture:
    """A picture without truth: its path, and what a detector sees in it: FaceFrame and landmarks (81, 2), pixels."""

    path: Path
    frame: FaceFrame
    points: np.ndarray


@dataclass(frozen=True)
class SeenFaces:
    """The largest faces of pictures without truth. unseen: pictures in which there is none, or that are none."""

    faces: list[SeenPicture] = field(default_factory=list)
    unseen: list[Path] = field(default_factory=list)

    def study(self, number: int) -> StudiedFace:
        """One of them. Raises InputError when its picture is no longer there."""
        seen = self.faces[number]
        pixels = read_image(seen.path)
        nothing = np.full(pixels.shape[:2], BEYOND, np.uint8)
        visible = np.isfinite(seen.points).all(1)
        return StudiedFace(MarkedPicture(pixels, nothing, seen.points[None], visible[None]), seen.frame, None)


@dataclass(frozen=True)
class PictureFolders:
    """What a training is on. marked: folders of ``caricli dataset pictures``. plain: folders of any pictures."""

    marked: list[Path]
    plain: list[Path]

    @classmethod
    def of(cls, folders: Sequence[Path]) -> "PictureFolders":
        """Sort folders out by what is in them. Raises InputError for what is no folder, and where no truth is."""
        for folder in folders:
            if not folder.is_dir():
                raise InputError(f"{shown(folder)}: expected a folder of pictures, found none")
        marked = [folder for folder in folders if is_picture_set(folder)]
        if not marked:
            raise InputError("expected a folder of `caricli dataset pictures` among --pictures, found none")
        return cls(marked, [folder for folder in folders if folder not in marked])

    @property
    def files(self) -> list[Path]:
        """The pictures of the plain folders."""
        return [path for folder in self.plain for path in pictures_in(folder)]

    def inputs(self) -> dict[str, str]:
        """SHA-256 by folder: of the manifest, or of those of all pictures."""
        digests = {str(folder / MANIFEST): sha256_file(folder / MANIFEST) for folder in self.marked}
        return digests | {str(folder): sha256_files(pictures_in(folder)) for folder in self.plain}


def see_faces(paths: Sequence[Path], detector: Detector, progress: Report = unwatched) -> SeenFaces:
    """Look for the faces of pictures. progress: called with those that were looked at, and of how many."""
    seen = SeenFaces()
    for done, path in enumerate(paths, 1):
        try:
            face = see_face(read_image(path), detector)
        except CaricliError:
            seen.unseen.append(path)
        else:
            points = face.landmarks.head_points
            assert len(points) == LANDMARKS
            seen.faces.append(SeenPicture(path, face.face.frame, points))
        progress(done, len(paths))
    return seen


@dataclass(frozen=True, eq=False)
class Ingredients:
    """What a training needs, and for its recipe what it is: SHA-256 by name, and whom it sees.

    sources: Sources. model: MorphableModel. detector: Detector. inputs, recipe: JSON objects.
    """

    sources: Sources
    model: MorphableModel
    detector: Detector
    inputs: dict[str, str]
    recipe: dict


def load_ingredients(
    data: Sequence[Path],
    folders: Sequence[Path],
    model: Path | None,
    detector: Path | None,
    progress: Report = unwatched,
) -> Ingredients:
    """Load datasets, pictures of their people, and any others, with their faces.

    data: one dataset, or one for each folder with truth, in their order. folders: see PictureFolders. model, detector:
    files, or None for the bundled ones. progress: as of ``see_faces``.
    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    pictures = PictureFolders.of(folders)
    pairs = list(zip(pictures.marked, _datasets(data, len(pictures.marked)), strict=True))
    morphable = load_morphable(model)
    sight = load_detector(detector)
    inputs = pictures.inputs() | {"morphable model": morphable.model_id, "detector": sight.model_id}
    train, validation = (
        JoinedFaces([_faces(folder, people, morphable, split) for folder, people in pairs])
        for split in ("train", "validation")
    )
    seen = see_faces(pictures.files, sight, progress)
    sources = Sources(train, seen if seen.faces else None, validation)
    about = {"unmarked": {"faces": len(seen.faces), "without": len(seen.unseen)}}
    return Ingredients(
        sources, morphable, sight, inputs, everybody([people for _, people in pairs]).as_recipe() | about
    )


def _datasets(folders: Sequence[Path], count: int) -> list[Dataset]:
    """A dataset for each of so many folders of pictures."""
    if len(folders) not in (1, count):
        raise InputError(f"expected one --data, or {count}, one for each folder of pictures, found {len(folders)}")
    datasets = [read_dataset(folder) for folder in folders]
    return datasets if len(datasets) == count else datasets * count


def _faces(folder: Path, dataset: Dataset, model: MorphableModel, split: str) -> TrueFaces:
    """The faces of a folder of pictures of a dataset's people."""
    with naming(folder):
        return TrueFaces(read_picture_set(folder), dataset, model, split)


class CoarseRun(RunFolder):
    """The folder of a coarse network's training."""

    curve = "shape error"
    axis = "mean distance in % of the head's height (validation: of the face, after alignment)"

    def follow(self, training: CoarseTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""

        def checkpoint() -> tuple[dict, dict]:
            network = training.copied_average()
            return coarse_to_checkpoint(
                CoarseModel(network, training.config.size, training.model.model_id, self.recipe)
            )

        return self.record(training, 1.0, checkpoint)

    def finish(self, training: CoarseTraining) -> dict:
        """Measure how far the best model usually is off, for those who fit faces about its word, and write the report.

        Returns the figures.
        """
        network = self.best_model(load_coarse)
        network.network.doubt.copy_(torch.from_numpy(training.doubts(network.network)))
        self.write_model(coarse_to_checkpoint(network))
        figures = {"model_id": network.model_id, "validation": 100 * training.best}
        self.report(figures)
        return figures
