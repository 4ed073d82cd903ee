"""What becomes of places and looks, told without any detector."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import cv2
import numpy as np
import pytest

from caricli.methods.detect import detect_faces as module
from caricli.methods.detect.detect_faces import detect_faces, seek_faces
from caricli.methods.detect.find_faces import Candidate
from caricli.methods.detect.parse_picture import WindowRegions
from caricli.methods.detect.read_faces import ReadFace
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.calibration import Calibration
from caricli.models.detector.model import Detector
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import EYES, JAW, MOUTH, OUTLINE
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape
from tests.grinning_face import GrinningFace
from tests.methods.detect.test_mark_as_people import JAW as JAW_PLACES

SETTINGS = DetectSettings()


@pytest.fixture
def seek(head_template, monkeypatch):
    """A function: faces as (x, y, size), and by scales pairs of a place that is taken for a face, that of one of them,
    and of the face that is then seen; to the faces that are found, and the scales that were asked for."""

    def found(faces, shown, spread=1.0):
        marks = [size * mean_shape(head_template) + [x, y] for x, y, size in faces]
        asked = []

        def find(_picture, _detector, sides, _settings):
            asked.append(sides)
            window = WindowRegions(np.full((4, 4, len(Region)), 1 / len(Region)), np.eye(2, 3))
            return [
                Candidate(replace(FaceFrame.of(marks[place]), roll=float(end)), 0.9) for place, end in shown[sides]
            ], [window]

        def look(_picture, frame, *_):
            points = marks[int(frame.roll)]
            seen = WindowRegions(np.zeros((4, 4, len(Region))), np.eye(2, 3))
            return ReadFace(frame, 0.9, points, np.tile(spread**2 * np.eye(2), (81, 1, 1)), np.ones(81), seen)

        monkeypatch.setattr(module, "find_faces", find)
        monkeypatch.setattr(module, "look_at_face", look)
        detection = seek_faces(np.zeros((400, 600, 3), np.uint8), None)
        sides = [FaceFrame.of(points).side for points in marks]
        order = [int(np.abs(np.array(sides) - face.frame.side).argmin()) for face in detection.faces]
        return order, asked

    return found


def test_the_largest_face_comes_first(seek):
    order, asked = seek([(100, 100, 70), (400, 200, 120)], {SETTINGS.sides: [(0, 0), (1, 1)]})
    assert order == [1, 0] and asked == [SETTINGS.sides]


def test_a_finer_scale_is_asked_where_faces_are_small_or_none_is_seen(seek):
    faces = [(100, 100, 20), (200, 100, 22), (400, 200, 30)]
    both = [SETTINGS.sides, SETTINGS.finer]
    assert seek(faces, {SETTINGS.sides: [(0, 0), (1, 1)], SETTINGS.finer: [(2, 2)]}) == ([2, 1, 0], both)
    assert seek(faces, {SETTINGS.sides: [], SETTINGS.finer: [(2, 2)]}) == ([2], both)


def test_two_places_whose_looks_end_at_one_face_are_one(seek):
    faces = [(150, 180, 120), (450, 180, 110)]
    assert seek(faces, {SETTINGS.sides: [(0, 0), (1, 0)]})[0] == [0]
    assert seek(faces, {SETTINGS.sides: [(0, 0), (1, 1)]})[0] == [0, 1]


def test_landmarks_that_are_nowhere_are_of_no_face(seek):
    shown = {SETTINGS.sides: [(0, 0)], SETTINGS.finer: []}
    assert seek([(300, 200, 100)], shown, spread=13.0)[0] == []
    assert seek([(300, 200, 100)], shown, spread=1.0)[0] == [0]


def test_what_is_read_goes_to_lips_lids_and_jaw_of_the_picture_and_then_to_where_people_mark(
    head_template, monkeypatch
):
    face = GrinningFace(head_template)
    outline = face.truth[list(OUTLINE)]
    beside = cv2.fillPoly(np.zeros((400, 400), np.uint8), [np.rint(outline).astype(np.int32)], 1) == 0
    regions = np.where(beside, Region.BACKGROUND, face.regions).astype(np.uint8)
    points = face.marks.points.copy()
    points[JAW] = points[JAW].mean(0) + 0.9 * (points[JAW] - points[JAW].mean(0))
    read = DetectedFace(FaceFrame.of(points), 0.9, replace(face.marks, points=points))
    monkeypatch.setattr(module, "seek_faces", lambda *_: Detection([read], regions))
    detection = detect_faces(face.image, cast(Detector, SimpleNamespace(calibration=Calibration(jaw=JAW_PLACES))))
    marks = detection.faces[0].landmarks
    for part in (EYES, MOUTH, range(4, 13)):
        before, after = (
            np.linalg.norm((own - face.truth)[list(part)], axis=1).mean() for own in (points, marks.head_points)
        )
        assert after < 0.6 * before
    assert np.abs(marks.slides[18]).max() > 0.1 and detection.regions is regions
