from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.detect_faces import _face, detect_faces
from caricli.methods.detect.find_faces import Candidate, frames_overlap
from caricli.methods.detect.parse_picture import WindowRegions, parse_picture
from caricli.methods.detect.read_faces import ReadFace
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.calibration import Calibration
from caricli.structures.detection import FaceFrame
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape

NOTHING = WindowRegions(np.zeros((32, 32, len(Region))), np.eye(2, 3))


def test_a_short_training_learns_where_landmarks_are(lesson):
    # All at the middle of the face would be 22 % off; the mean shape of so simple faces is 3 %.
    assert lesson[1].validation_error < 0.05


def test_faces_are_found_where_they_are_and_none_where_there_is_none(trained):
    detector, pictures = trained
    overlaps = []
    for number in pictures.numbers:
        picture = pictures.marked(number)
        # One that has learnt so little sees faces smaller at every look.
        faces = detect_faces(picture.pixels, detector, DetectSettings(looks=2, widest=np.inf)).faces
        assert faces == [] or len(picture.landmarks)
        assert [face.frame.side for face in faces] == sorted((face.frame.side for face in faces), reverse=True)
        frames = [FaceFrame.of(truth) for truth in picture.landmarks]
        overlaps += [max((frames_overlap(frame, face.frame) for face in faces), default=0) for frame in frames]
    assert np.mean(np.array(overlaps) > 0.3) >= 0.7, np.round(overlaps, 2)


def test_a_larger_picture_has_the_same_faces_and_regions(trained):
    detector, pictures = trained
    apart = []
    for number in (12, 13, 16, 17):
        pixels = pictures.marked(number).pixels
        usual = detect_faces(pixels, detector, DetectSettings(widest=np.inf))
        larger = detect_faces(cv2.resize(pixels, (640, 640)), detector, DetectSettings(widest=np.inf))
        assert len(larger.faces) == len(usual.faces) >= 1
        places = (larger.faces[0].landmarks.points + 0.5) / 4 - 0.5
        apart.append(np.linalg.norm(places - usual.faces[0].landmarks.points, axis=1))
        assert larger.regions.shape == (640, 640)
        assert (larger.regions[2::4, 2::4] == usual.regions).mean() > 0.9
    # Of one of them a network of seconds alone is two pixels unsure.
    assert np.nanmean(apart) < 1.5


def test_what_is_beyond_the_edge_or_vague_is_not_known(head_template):
    points = 60 * mean_shape(head_template) + [100 - 25, 60]
    spreads = np.tile(np.eye(2), (81, 1, 1))
    spreads[60] = np.diag([1.0, 400.0])
    frame = FaceFrame.of(points)
    read = ReadFace(frame, 0.9, points, spreads, np.ones(81), NOTHING)
    face = _face(Candidate(frame, 0.9), read, (100, 120), DetectSettings())
    spaced = space_jaw(points)
    unknown = (spaced[:, 0] > 101) | (np.arange(81) == 60)
    assert unknown.sum() > 3
    np.testing.assert_array_equal(face.landmarks.known, ~unknown)
    np.testing.assert_array_equal(np.isnan(face.landmarks.spreads[:, 0, 0]), unknown)
    assert face.score == pytest.approx(0.9) and face.frame.side == FaceFrame.of(spaced).side
    np.testing.assert_array_equal(face.landmarks.points[~unknown], spaced[~unknown])
    assert _face(Candidate(frame, 0.1), read, (100, 120), DetectSettings()) is None, "the search was not sure"
    assert _face(Candidate(frame, 0.9), read, (40, 120), DetectSettings()) is None, "too little of it is there"


@pytest.mark.parametrize("shape", [(1, 1), (20, 20000), (7, 300)])
def test_any_picture_can_be_asked(trained, shape):
    found = detect_faces(np.full((*shape, 3), 128, np.uint8), trained[0])
    assert found.regions.shape == shape and found.regions.dtype == np.uint8


def seen_eyes():
    """(32, 32, R) probabilities."""
    chances = np.full((32, 32, len(Region)), 0.01)
    chances[..., Region.BACKGROUND] = 0.5
    chances[8:16, 4:12, Region.EYES] = 1
    return chances


def test_regions_lie_where_they_were_seen():
    scale = 0.5
    matrix = np.array([[scale, 0, 0], [0, scale, 0]])
    regions = parse_picture((128, 128), WindowRegions(seen_eyes(), matrix), [])
    y, x = np.nonzero(regions == Region.EYES)
    # A pixel j of the map is at 2 j of the window, at 4 j of the picture.
    assert x.min() == pytest.approx(4 * 3.5, abs=1.5) and x.max() == pytest.approx(4 * 11.5, abs=1.5)
    assert y.min() == pytest.approx(4 * 7.5, abs=1.5) and y.max() == pytest.approx(4 * 15.5, abs=1.5)


def test_regions_lie_as_far_aside_as_the_detector_is_known_to_see_them():
    matrix = np.array([[0.05, 0, 0], [0, 0.05, 0]])
    shifted: Any = SimpleNamespace(calibration=Calibration(shift=(0.4, -0.2)))
    middles = []
    for window in (WindowRegions(seen_eyes(), matrix), WindowRegions.of(seen_eyes(), matrix, shifted)):
        y, x = np.nonzero(parse_picture((1280, 1280), window, []) == Region.EYES)
        middles.append(np.array([x.mean(), y.mean()]))
    # Pixels of the window are 20 of the picture.
    np.testing.assert_allclose(middles[1] - middles[0], [8, -4], atol=1)
