"""Faces with their landmarks and pictures, by path: landmarks that are given, or a picture in which they are found."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from caricli.errors import UsageError, naming, shown
from caricli.io.files import read_start
from caricli.io.image import is_image_file, read_image
from caricli.io.landmarks import write_landmarks
from caricli.store.pictures import load_found_marks
from caricli.structures.detection import FacePicture, SeenFace

if TYPE_CHECKING:
    from caricli.methods.detect.parse_face import GivenFace
    from caricli.models.detector.model import Detector


@dataclass(frozen=True)
class FaceReader:
    """Reads faces with their landmarks and pictures.

    path: of the detector, or None for the bundled one; it is loaded when the first picture asks for it. pts_origin:
    coordinate of the first pixel in .pts files.
    """

    path: Path | None = None
    pts_origin: int = 1

    @cached_property
    def detector(self) -> "Detector":
        """What finds faces. Raises InputError where it is none."""
        # Landmarks that are given need no detector.
        from caricli.store.detector import load_detector

        return load_detector(self.path)

    def read(self, path: Path, count: int, image: Path | None = None) -> FacePicture:
        """The FacePicture of a landmark file and its picture, or of a picture alone, in which the face is found.

        path: of landmarks or of a picture. count: landmarks that the mesh has; those that are found beyond are left
        out. image: path of the picture of landmarks.
        Raises InputError when there is neither, the picture shows no face, or landmarks cannot be of such a picture,
        and UsageError when there are two pictures.
        """
        read_start(path, 1, "a picture or a landmark file")
        if not is_image_file(path):
            return FacePicture(*load_found_marks(path, count, image, self.pts_origin))
        if image is not None:
            raise UsageError(f"{shown(path)} is a picture itself: --image is for landmarks")
        pixels = read_image(path)
        with naming(path):
            seen = self.see(pixels)
        return FacePicture(seen.landmarks.first(count), pixels, seen, seen.regions)

    def given(self, pixels: np.ndarray, points: np.ndarray) -> "GivenFace":
        """The face of landmarks (L, 2) in a picture (H, W, 3) uint8."""
        from caricli.methods.detect.parse_face import GivenFace

        return GivenFace(pixels, points, self.detector)

    def see(self, pixels: np.ndarray) -> SeenFace:
        """The face of a picture (H, W, 3) uint8. Raises InputError where it shows none."""
        detector = self.detector
        from caricli.methods.detect.see_face import see_face

        return see_face(pixels, detector)


def seen_files(path: Path, out: Path) -> list[Path]:
    """The file beside a result in which the landmarks are that are found for it, where its source is a picture.

    path: of the source.
    """
    return [_beside(out)] if is_image_file(path) else []


def write_seen_landmarks(out: Path, picture: FacePicture) -> None:
    """Write landmarks beside a result where they were found in the picture. Raises OutputError."""
    if picture.seen is not None:
        write_landmarks(_beside(out), picture.seen.landmarks)


def _beside(out: Path) -> Path:
    return out.with_name(f"{out.stem}-landmarks.json")
