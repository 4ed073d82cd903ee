"""A folder of pictures whose landmarks are placed one by one; the landmark files beside them tell which are done."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.landmarks import write_landmarks
from caricli.io.outputs import staged
from caricli.store.face_pictures import FaceReader
from caricli.store.pictures import MARKS, PICTURES, load_marked_picture, marks_beside, pictures_in
from caricli.structures import Landmarks


@dataclass(frozen=True)
class MarkedFolder:
    """Pictures and where their landmarks are.

    pictures: paths, in the order in which they are gone through. Landmarks in .pts files count from 1.
    """

    pictures: tuple[Path, ...]

    @staticmethod
    def of(path: Path) -> "MarkedFolder":
        """The pictures of a folder by their names, or one picture.

        Raises InputError where there are none, and where two of them would share a landmark file.
        """
        if not path.is_dir():
            return MarkedFolder((path,))
        pictures = tuple(pictures_in(path))
        if not pictures:
            raise InputError(f"{shown(path)}: expected pictures ({', '.join(PICTURES)}), found none")
        by_stem: dict[str, Path] = {}
        for picture in pictures:
            other = by_stem.setdefault(picture.stem, picture)
            if other != picture:
                pair = f"{shown(other.name)} and {shown(picture.name)}"
                raise InputError(f"{shown(path)}: expected pictures whose names differ before the suffix, found {pair}")
        return MarkedFolder(pictures)

    def file(self, picture: Path) -> Path:
        """The landmark file beside a picture; where there is none, where it will be. Others may have its name."""
        return marks_beside(picture) or picture.with_suffix(MARKS[0])

    def is_done(self, picture: Path) -> bool:
        """Whether there are landmarks beside a picture."""
        return marks_beside(picture) is not None

    @property
    def done(self) -> int:
        """How many pictures have landmarks."""
        return sum(map(self.is_done, self.pictures))

    def first(self) -> Path:
        """The first picture that is not done, or the first of all."""
        return next((picture for picture in self.pictures if not self.is_done(picture)), self.pictures[0])

    def others(self, picture: Path, step: int = 1) -> list[Path]:
        """All pictures but one, from the next one on, around the end. step: 1, or -1 for backwards."""
        place = self.pictures.index(picture)
        return [self.pictures[(place + step * k) % len(self.pictures)] for k in range(1, len(self.pictures))]

    def left(self, picture: Path) -> list[Path]:
        """Those of the others that are not done."""
        return [each for each in self.others(picture) if not self.is_done(each)]

    def candidates(self, picture: Path) -> list[Path]:
        """A picture to begin with, and those to take where it cannot be read: first what is not done."""
        return [picture, *sorted(self.others(picture), key=self.is_done)]

    def read(self, picture: Path) -> Landmarks | None:
        """Landmarks of a picture, or None where it has none yet. Raises InputError where they are of another."""
        file = self.file(picture)
        return load_marked_picture(file, picture)[0] if file.is_file() else None

    def write(self, picture: Path, landmarks: Landmarks) -> Path:
        """Write landmarks beside a picture, in the format that they have there, and say where.

        What is there is replaced where it holds landmarks of such a picture. Raises OutputError where it holds
        something else, or nothing can be written.
        """
        file = self.file(picture)
        try:
            self.read(picture)
        except InputError as error:
            raise OutputError(f"{error}; it is not replaced") from error
        with staged(file, overwrite=True, inputs=(picture,)) as temporaries:
            write_landmarks(temporaries[0], landmarks)
        return file


def seen_marks(pixels: np.ndarray, count: int, reader: FaceReader) -> Landmarks | None:
    """Landmarks that the detector finds in a picture, or None where it sees no face.

    pixels: (H, W, 3) uint8. count: of landmarks that the mesh has.
    """
    try:
        return reader.see(pixels).landmarks.first(count)
    except InputError:
        return None
