"""What a picture shows around a face whose landmarks are given."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from caricli.methods.detect.detect_faces import seek_faces
from caricli.methods.detect.find_faces import frames_overlap
from caricli.methods.detect.parse_picture import WindowRegions, parse_picture
from caricli.methods.detect.read_faces import ReadFace, read_face
from caricli.methods.detect.see_face import doubt_of
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.model import Detector
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import Detection, FaceFrame
from caricli.structures.landmarks import COUNT, EYES, MOUTH

_WIDE = 2
"""Windows' sides of the one in which a head and its surroundings are parsed."""

_SAME = 0.5
"""Overlap of the frames of landmarks and of a face that is found, from which on these are of one face."""

_NEAR = 0.1
"""Of the diagonal of landmarks: so far those that are seen are from them, at most, in the mean, where the picture is
theirs. Of 110 generated ones none is, to what is seen of it, farther than 0.051; of 440 others 95 % are surely so."""


@dataclass(frozen=True, eq=False)
class GivenFace:
    """A face whose landmarks are given, in a picture.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, NaN where unknown. detector: Detector. settings: DetectSettings.
    """

    picture: np.ndarray
    points: np.ndarray
    detector: Detector
    settings: DetectSettings = DetectSettings()  # noqa: RUF009 (frozen)

    @cached_property
    def sought(self) -> Detection:
        """What `seek_faces` finds in the whole picture."""
        return seek_faces(self.picture, self.detector, self.settings)

    @cached_property
    def parsed(self) -> "ParsedFace":
        """What is read around the landmarks alone."""
        return parse_face(self.picture, self.points, self.detector, self.settings)

    @property
    def regions(self) -> np.ndarray:
        """(H, W) uint8 values of Region, what the picture shows.

        Where this face is found in the picture, it is what its detection says, a mean of looks at several scales; else
        what is read around the landmarks alone.
        """
        frame = FaceFrame.of(_filled(self.points))
        if any(frames_overlap(frame, face.frame) >= _SAME for face in self.sought.faces):
            return self.sought.regions
        return self.parsed.regions

    @property
    def elsewhere(self) -> bool:
        """Whether the picture surely shows a face, and none, sure or not, where the landmarks are."""
        faces = self.sought.faces
        sure = any(doubt_of(face, self.settings) is None for face in faces)
        if not sure or any(self._is_near(face.landmarks.head_points) for face in faces):
            return False
        read = self.parsed.read
        return not (read.is_hopeful(self.settings) and self._is_near(read.points))

    def _is_near(self, seen: np.ndarray) -> bool:
        """Whether landmarks (81, 2), NaN where unknown, are those that are given."""
        away = np.linalg.norm(seen[:COUNT] - self.points[:COUNT], axis=1)
        diagonal = np.linalg.norm(np.ptp(_filled(self.points), axis=0))
        return bool(np.nanmean(away) < _NEAR * diagonal) if np.isfinite(away).any() else False


@dataclass(frozen=True, eq=False)
class ParsedFace:
    """What was read where a face is.

    read: ReadFace. regions: (H, W) uint8 values of Region, background far from the face.
    """

    read: ReadFace
    regions: np.ndarray


def parse_face(
    picture: np.ndarray, points: np.ndarray, detector: Detector, settings: DetectSettings | None = None
) -> ParsedFace:
    """Read the face that landmarks are of, and say what the pixels around it show; nothing is searched for.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, NaN where unknown.
    """
    settings = settings or DetectSettings()
    frame = FaceFrame.of(_filled(points))
    read = read_face(picture, frame, settings.second, detector)
    size = _WIDE * detector.size
    matrix = frame.matrix(size, _WIDE / settings.parse)
    around = WindowRegions.of(detector.parse(cut_window(picture, matrix, (size, size))), matrix, detector)
    regions = parse_picture(picture.shape[:2], around, [read.shown])
    return ParsedFace(read, regions)


def _filled(points: np.ndarray) -> np.ndarray:
    """Landmarks (68, 2) with the middle of the others of its part, or of all, for each unknown one."""
    filled = np.array(points[:COUNT], np.float64)
    for part in (EYES, MOUTH, range(COUNT)):
        own = filled[list(part)]
        given = np.isfinite(own[:, 0])
        if given.any():
            filled[list(part)] = np.where(given[:, None], own, own[given].mean(0))
    return filled
