import numpy as np
import pytest

from caricli.render.sheets.detection_sheet import HIDDEN, SEEN, detection_sheet, smaller
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


@pytest.mark.parametrize(("visibility", "colour"), [(0.9, SEEN), (0.1, HIDDEN)])
@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0])
def test_an_ellipse_is_one_standard_deviation_and_a_dot_says_whether_it_is_seen(
    head_template, angle, visibility, colour
):
    points = np.full((81, 2), np.nan)
    points[30:40] = 100, 90
    points[40] = 100, 290
    along = np.array([np.cos(angle), np.sin(angle)])
    spread = 5.0**2 * np.eye(2) + (40.0**2 - 5.0**2) * np.outer(along, along)
    marks = Landmarks(points, (200, 300), np.tile(spread, (81, 1, 1)), np.full(81, visibility))
    face = DetectedFace(FaceFrame.of(mean_shape(head_template)), 0.9, marks)
    grey = np.full((300, 200, 3), 128, np.uint8)
    sheet = detection_sheet(grey, Detection([face], np.zeros((300, 200), np.uint8)), opacity=0.0)[:, :200]
    assert (sheet[90, 100] == colour).all()
    rows, columns = np.nonzero((sheet[:200] > 190).all(2))
    away = np.stack([columns, rows], 1) - points[30]
    assert np.abs(away @ along).max() == pytest.approx(40, abs=2.5)
    assert np.abs(away @ [-along[1], along[0]]).max() == pytest.approx(5, abs=1.5)


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
