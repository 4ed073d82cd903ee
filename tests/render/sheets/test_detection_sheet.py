import numpy as np

from caricli.render.sheets.detection_sheet import detection_sheet, smaller
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import Landmarks
from caricli.structures.parsing import REGION_COLOURS, Region
from caricli.structures.zoomed_pixels import zoomed_pixels
from tests.drawn_pictures import drawn_picture, mean_shape


def test_faces_and_regions_are_drawn(head_template):
    picture = drawn_picture(mean_shape(head_template), np.random.default_rng(0))
    points = picture.landmarks[0].copy()
    points[3] = np.nan
    spreads = np.tile(np.diag([4.0, 9.0]), (81, 1, 1))
    marks = Landmarks(points, (160, 160), spreads, np.where(np.arange(81) < 40, 0.9, 0.1))
    face = DetectedFace(FaceFrame.of(picture.landmarks[0]), 0.9, marks)
    sheet = detection_sheet(picture.pixels, Detection([face], picture.regions), opacity=1.0)
    assert sheet.shape == (160, 320, 3)
    assert (sheet[:, 160:][picture.regions == Region.SKIN] == REGION_COLOURS[Region.SKIN]).all()
    left = np.abs(sheet[:, :160].astype(int) - picture.pixels).max(2) > 30
    places = np.rint(np.delete(picture.landmarks[0], 3, 0)).astype(int)
    assert left[places[:, 1], places[:, 0]].all()


def test_a_large_picture_is_drawn_over_smaller(head_template, monkeypatch):
    picture = drawn_picture(mean_shape(head_template), np.random.default_rng(0))
    marks = Landmarks(picture.landmarks[0], (160, 160), np.tile(np.eye(2), (81, 1, 1)), np.ones(81))
    found = Detection([DetectedFace(FaceFrame.of(picture.landmarks[0]), 0.9, marks)], picture.regions)
    whole = detection_sheet(picture.pixels, found)
    monkeypatch.setattr("caricli.render.sheets.detection_sheet.LONGEST", 160)
    large = np.repeat(np.repeat(picture.pixels, 4, 0), 4, 1)
    points = zoomed_pixels(picture.landmarks[0], 4)
    marks = Landmarks(points, (640, 640), np.tile(16 * np.eye(2), (81, 1, 1)), np.ones(81))
    regions = np.repeat(np.repeat(picture.regions, 4, 0), 4, 1)
    np.testing.assert_array_equal(
        detection_sheet(large, Detection([DetectedFace(FaceFrame.of(points), 0.9, marks)], regions)), whole
    )


def test_large_pictures_become_small_ones():
    assert smaller(np.zeros((100, 400, 3), np.uint8), 200).shape == (50, 200, 3)
    assert smaller(np.zeros((10, 40, 3), np.uint8), 200).shape == (10, 40, 3)
