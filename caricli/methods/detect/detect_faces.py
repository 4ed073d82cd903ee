"""Faces of a picture, with their landmarks, and its regions."""

from dataclasses import dataclass, field, replace
from statistics import median

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.find_faces import Candidate, common_share, find_faces
from caricli.methods.detect.mark_as_people import mark_as_people
from caricli.methods.detect.parse_picture import WindowRegions, mean_regions, parse_picture
from caricli.methods.detect.read_faces import ReadFace, look_at_face
from caricli.methods.detect.settings import DetectSettings
from caricli.methods.detect.snap_jaw import snap_jaw
from caricli.methods.detect.snap_openings import snap_openings
from caricli.models.detector.model import Detector
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import Landmarks

_STEEP = 8  # so that faces whose landmarks are sure keep their score, and others lose it


def detect_faces(picture: np.ndarray, detector: Detector, settings: DetectSettings | None = None) -> Detection:
    """Find all faces of a picture, read their landmarks, and say what every pixel shows.

    Lips, lids and jaw of what `seek_faces` reads go to where the picture shows them, then all points to where people
    mark them.
    picture: (H, W, 3) uint8.
    """
    sought = seek_faces(picture, detector, settings)
    regions = sought.regions
    snapped = [snap_jaw(regions, snap_openings(picture, regions, face.landmarks)) for face in sought.faces]
    marks = [mark_as_people(face, detector.calibration.jaw) for face in snapped]
    return Detection([replace(face, landmarks=own) for face, own in zip(sought.faces, marks, strict=True)], regions)


def seek_faces(picture: np.ndarray, detector: Detector, settings: DetectSettings | None = None) -> Detection:
    """Find all faces of a picture, and say what every pixel shows, with landmarks as the network reads them.

    The picture is searched at several scales, and where faces are small or none is found at a finer one, too; each
    place that may hold a face is looked at in the frame that the search gave, and in that of the landmarks that were
    seen there. A face is what search and last look are sure of, and whose landmarks are somewhere. Of regions the mean
    of what all scales show counts, and where a face is that of it and the last look.
    picture: (H, W, 3) uint8.
    """
    search = _Search(picture, detector, settings or DetectSettings())
    search.at(search.settings.sides)
    if search.shows_small_faces():
        search.at(search.settings.finer)
    pairs = sorted(search.pairs, key=lambda pair: -pair[0].frame.side)
    whole = mean_regions(search.glances)
    own = [mean_regions([whole, read.shown]) for _, read in pairs]
    return Detection([face for face, _ in pairs], parse_picture(picture.shape[:2], whole, own))


@dataclass(frozen=True, eq=False)
class _Search:
    """What is found in a picture (H, W, 3) uint8.

    pairs: faces with what they were read as, each once. glances: what the picture shows by every scale.
    """

    picture: np.ndarray
    detector: Detector
    settings: DetectSettings
    pairs: list[tuple[DetectedFace, ReadFace]] = field(default_factory=list)
    glances: list[WindowRegions] = field(default_factory=list)

    def at(self, sides: tuple[float, ...]) -> None:
        """Search the picture at some scales, its longer sides, and look at what may be a face there."""
        candidates, glances = find_faces(self.picture, self.detector, sides, self.settings)
        self.glances.extend(glances)
        size = (self.picture.shape[1], self.picture.shape[0])
        for candidate in candidates:
            # What a face that was found covers needs no look.
            if self._is_new(candidate.frame):
                read = look_at_face(self.picture, candidate.frame, self.detector, self.settings)
                face = _face(candidate, read, size, self.settings)
                if face is not None and self._is_new(face.frame):
                    self.pairs.append((face, read))

    def shows_small_faces(self) -> bool:
        """Whether its faces are small, most of them, or none was found."""
        sides = [face.frame.side for face, _ in self.pairs]
        return not sides or median(sides) < self.settings.small * max(self.picture.shape[:2])

    def _is_new(self, frame: FaceFrame) -> bool:
        return all(common_share(frame, face.frame) <= self.settings.overlap for face, _ in self.pairs)


def _face(candidate: Candidate, read: ReadFace, size: tuple[int, int], settings: DetectSettings) -> DetectedFace | None:
    """The face that was read at a place, or None where there is none, or too little of one in the picture.

    The jaw's points are spaced as the network learnt them.
    """
    score = float(np.sqrt(candidate.score * read.score))
    if score < settings.sure or not np.isfinite(read.points).all():
        return None
    read = replace(read, points=space_jaw(read.points))
    frame = FaceFrame.of(read.points)
    margin = settings.margin * frame.side
    beyond = ((read.points < -0.5 - margin) | (read.points > np.array(size) - 0.5 + margin)).any(1)
    diagonal = np.linalg.norm(np.ptp(read.points, axis=0))
    vague = np.sqrt(np.linalg.eigvalsh(read.spreads)[:, 1]) > settings.vague * diagonal
    unknown = beyond | vague
    points = np.where(unknown[:, None], np.nan, read.points)
    spreads = np.where(unknown[:, None, None], np.nan, read.spreads)
    try:
        landmarks = Landmarks(points, size, spreads, np.clip(read.visible, 0, 1))
    except InputError:
        return None
    face = DetectedFace(frame, score, landmarks)
    return face if score * _certainty(face.spread, settings) >= settings.sure else None


def _certainty(spread: float, settings: DetectSettings) -> float:
    """What a score counts for where landmarks have a spread: 1 for none, a half for the widest."""
    return 1 / (1 + (spread / settings.widest) ** _STEEP)
