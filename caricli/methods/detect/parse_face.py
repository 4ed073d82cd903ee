"""What a picture shows around a face whose landmarks are given."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.find_faces import frames_overlap
from caricli.methods.detect.parse_picture import WindowRegions, parse_picture
from caricli.methods.detect.read_faces import ReadFace, read_face
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.model import Detector
from caricli.render.cut_window import cut_window
from caricli.structures.detection import FaceFrame
from caricli.structures.landmarks import COUNT, EYES, MOUTH

_WIDE = 2
"""Windows' sides of the one in which a head and its surroundings are parsed."""

_SAME = 0.5
"""Overlap of the frames of landmarks and of a face that is found, from which on these are of one face."""


@dataclass(frozen=True, eq=False)
class ParsedFace:
    """What was read where a face is.

    read: ReadFace. regions: (H, W) uint8 values of Region, background far from the face.
    """

    read: ReadFace
    regions: np.ndarray


def parse_around(
    picture: np.ndarray, points: np.ndarray, detector: Detector, settings: DetectSettings | None = None
) -> np.ndarray:
    """Say what a picture shows whose face has landmarks.

    Where this face is found in the picture, it is what its detection says, a mean of looks at several scales; else what
    is read around the landmarks alone.
    picture: (H, W, 3) uint8. points: (L, 2) pixels, NaN where unknown.
    Returns (H, W) uint8 values of Region.
    """
    detection = detect_faces(picture, detector, settings)
    frame = FaceFrame.of(_filled(points))
    if any(frames_overlap(frame, face.frame) >= _SAME for face in detection.faces):
        return detection.regions
    return parse_face(picture, points, detector, settings).regions


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
    around = WindowRegions(detector.parse(cut_window(picture, matrix, (size, size))), matrix)
    regions = parse_picture(picture.shape[:2], around, [WindowRegions(read.regions, read.matrix)])
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
