"""Pictures of a split, as trainings take them."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from caricli.data.picture_set import PictureSet
from caricli.geometry.lines.mark_lines import mark_lines
from caricli.geometry.lines.space_jaw import carry_jaw, space_jaw
from caricli.structures.detection import MarkedPicture

SEEN = 0.25
"""Share of its landmarks that must be visible for a face to be learnt from: of a few nothing can be told."""


class SplitPictures:
    """Pictures of a PictureSet with people of one split alone, or nobody, and their faces of which enough is seen."""

    def __init__(self, pictures: PictureSet, split: str) -> None:
        """split: its name."""
        self.pictures = pictures
        self.numbers: Sequence[int] = pictures.pictures_of(split).tolist()
        seen = pictures.truth["visible"].mean(1) >= SEEN
        self.faces: Sequence[tuple[int, int]] = [
            (number, place) for number in self.numbers for place, row in enumerate(pictures.faces(number)) if seen[row]
        ]

    def marked(self, number: int) -> MarkedPicture:
        """A picture with its truth. Raises InputError when a file is missing or damaged."""
        return marked_picture(self.pictures, number)

    def landmarks(self) -> np.ndarray:
        """(F, L, 2) true landmarks of all faces, pixels of their pictures."""
        rows = [self.pictures.faces(number)[place] for number, place in self.faces]
        return self.pictures.truth["landmarks"][rows].astype(np.float64)


class JoinedPictures:
    """Pictures of several SplitPictures, numbered on from one to the next."""

    def __init__(self, parts: Sequence[SplitPictures]) -> None:
        """parts: at least one."""
        self.parts = parts
        self.starts = np.cumsum([0, *(part.pictures.count for part in parts)]).tolist()
        pairs = list(zip(self.starts, parts, strict=False))
        self.numbers: Sequence[int] = [start + number for start, part in pairs for number in part.numbers]
        self.faces: Sequence[tuple[int, int]] = [
            (start + number, place) for start, part in pairs for number, place in part.faces
        ]

    def marked(self, number: int) -> MarkedPicture:
        """A picture with its truth. Raises InputError when a file is missing or damaged."""
        part = bisect_right(self.starts, number) - 1
        return self.parts[part].marked(number - self.starts[part])

    def landmarks(self) -> np.ndarray:
        """(F, L, 2) true landmarks of all faces, pixels of their pictures."""
        return np.concatenate([part.landmarks() for part in self.parts])


def marked_picture(pictures: PictureSet, number: int) -> MarkedPicture:
    """A picture with its truth. Raises InputError when a file is missing or damaged."""
    rows = pictures.faces(number)
    points = pictures.truth["landmarks"][rows].astype(np.float64)
    visible = pictures.truth["visible"][rows].astype(bool)
    return MarkedPicture(pictures.picture(number), pictures.regions(number), points, visible)


def evenly_jawed(picture: MarkedPicture) -> MarkedPicture:
    """A picture whose jaws are marked at equal distances, as networks learn them: where vertices lie cannot be seen."""
    return _marked(picture, space_jaw)


def marked_by_people(picture: MarkedPicture) -> MarkedPicture:
    """A picture whose faces are marked as people do it, and as they are detected."""
    return _marked(picture, lambda points: mark_lines(carry_jaw(points)))


def _marked(picture: MarkedPicture, move: Callable[[np.ndarray], np.ndarray]) -> MarkedPicture:
    points = np.array([move(face) for face in picture.landmarks])
    return replace(picture, landmarks=points.reshape(picture.landmarks.shape))
