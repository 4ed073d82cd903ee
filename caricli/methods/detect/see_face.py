"""The one face that a picture is taken for."""

import numpy as np

from caricli.errors import InputError
from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.model import Detector
from caricli.structures.detection import DetectedFace, SeenFace


def see_face(picture: np.ndarray, detector: Detector, settings: DetectSettings | None = None) -> SeenFace:
    """Find the face that a picture (H, W, 3) uint8 is of, see ``main_face``.

    Raises InputError where the picture shows no face.
    """
    settings = settings or DetectSettings()
    detection = detect_faces(picture, detector, settings)
    if not detection.faces:
        raise InputError("expected a face, found none")
    face = main_face(detection.faces, settings)
    return SeenFace(face, detection.regions, len(detection.faces) - 1, doubt_of(face, settings))


def main_face(faces: list[DetectedFace], settings: DetectSettings) -> DetectedFace:
    """Of faces, the largest first: the largest that nothing speaks against, or the largest."""
    return next((face for face in faces if doubt_of(face, settings) is None), faces[0])


def doubt_of(face: DetectedFace, settings: DetectSettings) -> str | None:
    """What speaks against a face, or None."""
    count = int(face.landmarks.known.sum())
    reasons = {
        f"its score is {face.score:.2f}": face.score < settings.doubtful,
        f"its landmarks are to {100 * face.spread:.1f} % of its diagonal": face.spread > settings.blurred,
        f"only {count} of its {len(face.landmarks.points)} landmarks can be seen": count < settings.fewest,
    }
    given = [reason for reason, holds in reasons.items() if holds]
    return ", ".join(given) or None
