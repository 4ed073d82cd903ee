from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.see_face import main_face, see_face
from caricli.methods.detect.settings import DetectSettings
from caricli.structures.detection import DetectedFace, FaceFrame
from caricli.structures.landmarks import Landmarks
from tests.drawn_pictures import mean_shape

# One that has learnt so little is sure of no landmark.
UNSURE = DetectSettings(widest=np.inf)


@pytest.fixture(scope="module")
def shown(trained):
    """A Detector, a picture in which it finds a face, and its Detection."""
    detector, pictures = trained
    picture = pictures.marked(12).pixels
    return detector, picture, detect_faces(picture, detector, UNSURE)


def test_the_largest_face_is_seen_with_the_regions_of_the_picture(shown):
    detector, picture, detection = shown
    seen = see_face(picture, detector, UNSURE)
    np.testing.assert_array_equal(seen.landmarks.points, detection.faces[0].landmarks.points)
    np.testing.assert_array_equal(seen.regions, detection.regions)
    assert seen.others == len(detection.faces) - 1


def test_what_speaks_against_a_face_is_said(shown):
    detector, picture, detection = shown
    face = detection.faces[0]
    trusting = replace(UNSURE, doubtful=0, blurred=np.inf, fewest=0)
    assert see_face(picture, detector, trusting).doubt is None
    unsure = see_face(picture, detector, replace(trusting, doubtful=1)).doubt
    assert unsure == f"its score is {face.score:.2f}"
    both = see_face(picture, detector, replace(trusting, blurred=0, fewest=82)).doubt
    count = face.landmarks.known.sum()
    spread = f"its landmarks are to {100 * face.spread:.1f} % of its diagonal"
    assert both == f"{spread}, only {count} of its 81 landmarks can be seen"


def test_a_smaller_face_that_is_sure_goes_before_a_larger_one_that_is_not(head_template):
    def face(score, side):
        points = side * mean_shape(head_template) + side
        landmarks = Landmarks(points, (500, 500), np.tile(np.eye(2), (81, 1, 1)))
        return DetectedFace(FaceFrame.of(points), score, landmarks)

    larger, smaller = face(0.5, 150), face(0.9, 80)
    assert main_face([larger, smaller], DetectSettings()) is smaller
    assert main_face([larger, smaller], DetectSettings(doubtful=0.4)) is larger
    assert main_face([larger, smaller], DetectSettings(doubtful=0.95)) is larger


def test_a_picture_without_a_face_is_refused(shown):
    with pytest.raises(InputError, match="expected a face, found none"):
        see_face(np.full((64, 64, 3), 128, np.uint8), shown[0], DetectSettings().sure_of(1))
