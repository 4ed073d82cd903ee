"""Landmarks of faces whose place is known roughly."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.detect.find_faces import frames_overlap
from caricli.methods.detect.parse_picture import WindowRegions
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.config import HALF
from caricli.models.detector.model import Detector
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import FaceFrame
from caricli.structures.landmarks import MIRRORED


@dataclass(frozen=True, eq=False)
class ReadFace:
    """A face as it was read.

    frame: FaceFrame in which it was. score: 0 to 1. points: (81, 2) pixels of the picture. spreads: (81, 2, 2) square
    pixels. visible: (81,) 0 to 1. shown: WindowRegions of its window.
    """

    frame: FaceFrame
    score: float
    points: np.ndarray
    spreads: np.ndarray
    visible: np.ndarray
    shown: WindowRegions

    @property
    def spread(self) -> float:
        """How far its landmarks may be off: root mean square of their spreads, a share of the diagonal of all."""
        return float(
            np.sqrt(np.trace(self.spreads, axis1=1, axis2=2).mean()) / np.linalg.norm(np.ptp(self.points, axis=0))
        )

    def is_hopeful(self, settings: DetectSettings) -> bool:
        """Whether there may be a face; where there is none, landmarks are those of a usual one, and not sure."""
        return self.score >= settings.start and self.spread <= 2 * settings.widest


def look_at_face(picture: np.ndarray, frame: FaceFrame, detector: Detector, settings: DetectSettings) -> ReadFace:
    """Look at the face in a frame of a picture (H, W, 3) uint8, and then again in the frame of the landmarks just seen.

    It ends where these frames agree, after ``settings.looks``, or where the first sees no face at all, or landmarks
    twice as wide as a face may have them. Every look is at the window and its mirror image, whose means are taken;
    where they differ is doubt, too.
    """
    read = read_face(picture, frame, settings.first, detector)
    for _ in range(settings.looks - 1 if read.is_hopeful(settings) else 0):
        frame = FaceFrame.of(read.points)
        read = read_face(picture, frame, settings.second, detector)
        if frames_overlap(frame, FaceFrame.of(read.points)) > settings.agree:
            break
    return read


def read_face(picture: np.ndarray, frame: FaceFrame, share: float, detector: Detector) -> ReadFace:
    """Read the face in a frame of a picture (H, W, 3) uint8. share: of the window's side to the face's."""
    size = detector.size
    matrix = frame.matrix(size, share)
    window = cut_window(picture, matrix, (size, size))
    reading = detector.read(np.stack([window, window[:, ::-1]]))
    turned = reading.points[1, list(MIRRORED)] * [-1, 1] + [size - 1, 0]
    apart = (reading.points[0] - turned) / 2
    mirror = np.diag([-1.0, 1.0])
    spreads = (reading.covariance[0] + mirror @ reading.covariance[1, list(MIRRORED)] @ mirror) / 2
    spreads += apart[:, :, None] * apart[:, None, :]
    back = np.linalg.inv(matrix[:, :2])
    turned_regions = _mirrored_regions(reading.regions[1], detector.calibration.shift[0])
    return ReadFace(
        frame,
        float(reading.score.mean()),
        ((reading.points[0] + turned) / 2 - matrix[:, 2]) @ back.T,
        _symmetric(back @ spreads @ back.T),
        (reading.visible[0] + reading.visible[1, list(MIRRORED)]) / 2,
        WindowRegions.of((reading.regions[0] + turned_regions) / 2, matrix, detector),
    )


def _symmetric(matrices: np.ndarray) -> np.ndarray:
    return (matrices + matrices.swapaxes(-1, -2)) / 2


def _mirrored_regions(regions: np.ndarray, shift: float) -> np.ndarray:
    """Regions (h, w, R) of a mirrored window as in the window itself: there they lie farther to the right.

    shift: pixels of the window that regions are to the right of 2 j; those of a mirrored one are to the left.
    """
    turned = regions[:, ::-1]
    farther = (1 - 2 * shift) / HALF
    return turned + farther * (np.concatenate([turned[:, :1], turned[:, :-1]], axis=1) - turned)
