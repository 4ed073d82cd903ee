"""Pictures that detectors are measured on: generated ones, and real ones with landmarks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.data.dataset import SPLITS
from caricli.data.picture_set import MANIFEST, PictureSet, read_picture_set
from caricli.data.unseen import strange_splits
from caricli.errors import InputError
from caricli.io.provenance import made_of
from caricli.methods.evaluate.evaluate_detector import UNKNOWN, JudgedPicture
from caricli.methods.train.detector.split_pictures import marked_by_people, marked_picture
from caricli.models.detector.model import Detector
from caricli.store.pictures import load_marked_picture
from caricli.store.portraits import portrait_files
from caricli.structures import SeenPeople
from caricli.structures.detection import MarkedPicture
from caricli.structures.landmarks import COUNT


@dataclass(frozen=True, eq=False)
class JudgedPictures:
    """Pictures of a PictureSet, by their numbers, each read when it is its turn."""

    pictures: PictureSet
    numbers: list[int]

    def __len__(self) -> int:
        """How many there are."""
        return len(self.numbers)

    def __iter__(self) -> Iterator[JudgedPicture]:
        """One after the other."""
        truth = self.pictures.truth
        for number in self.numbers:
            marked = marked_by_people(marked_picture(self.pictures, number))
            rows = self.pictures.faces(number)
            # The head's front is the third axis; how far it points to the side is the sine of the yaw.
            yaws = np.degrees(np.arcsin(np.clip(truth["rotation"][rows][:, 0, 2], -1, 1)))
            yield JudgedPicture(marked, f"{number:06d}", self.pictures.media[number], yaws)


def judged_inputs(pictures: Path | None, real: Path | None) -> list[Path]:
    """The files that say what is measured: the manifest of generated pictures, real ones and their landmarks."""
    manifest = [] if pictures is None else [pictures / MANIFEST]
    return [*manifest, *(path for pair in portrait_files(real) for path in pair)]


def load_judged_sets(
    pictures: Path | None, real: Path | None, detector: Detector, count: int, pts_origin: int
) -> tuple[dict[str, Sequence[JudgedPicture] | JudgedPictures], str | None]:
    """Generated pictures of a folder of ``caricli dataset pictures``, and real ones, at most so many, where given.

    Where a detector has seen some of the folder's people, only those of test people. Returns the sets by name, and one
    line about them, or None where there is nothing to say. Raises InputError when something is missing or damaged, and
    where it has seen some of these, too.
    """
    sets: dict[str, Sequence[JudgedPicture] | JudgedPictures] = {}
    note = None
    if pictures is not None:
        sets["generated"], note = _generated(pictures, detector, count)
    if real is not None:
        sets["real"] = [_real(*pair, pts_origin) for pair in portrait_files(real)[:count]]
    return sets, note


def _generated(folder: Path, detector: Detector, count: int) -> tuple[JudgedPictures, str | None]:
    pictures = read_picture_set(folder)
    seen = SeenPeople.of_recipe(detector.recipe)
    strange = list(SPLITS) if seen is None else strange_splits(pictures.manifest, seen)
    if "test" not in strange:
        raise InputError(f"{folder}: expected test people whom the detector was not trained with, found some of them")
    if made_of(detector.recipe, folder / MANIFEST) or len(strange) < len(SPLITS):
        numbers = pictures.pictures_of("test").tolist()
        note = f"{folder}: the detector has seen some of its people; measured on {len(numbers)} pictures of others"
        return JudgedPictures(pictures, numbers[:count]), note
    silent = f"{folder}: no word of whom the detector was trained with, who may be in it"
    return JudgedPictures(pictures, [*range(pictures.count)][:count]), silent if seen is None else None


def _real(path: Path, marks: Path, pts_origin: int) -> JudgedPicture:
    """A real picture with one face."""
    landmarks, pixels = load_marked_picture(marks, path, pts_origin)
    assert pixels is not None
    if not landmarks.known[:COUNT].all():
        raise InputError(f"{marks}: expected all {COUNT} points of iBUG, found {landmarks.known[:COUNT].sum()}")
    nothing = np.full(pixels.shape[:2], UNKNOWN, np.uint8)
    points = landmarks.points[None]
    return JudgedPicture(MarkedPicture(pixels, nothing, points, np.ones(points.shape[:2], bool)), path.stem, "real")
