import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_detector import DetectorTally, JudgedPicture
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import Landmarks
from tests.drawn_pictures import drawn_picture, mean_shape


@pytest.fixture(scope="module")
def picture(head_template):
    return drawn_picture(mean_shape(head_template), np.random.default_rng(2), faces=2)


def found(points, variance=1.0):
    marks = Landmarks(points, None, np.tile(variance * np.eye(2), (81, 1, 1)))
    return DetectedFace(FaceFrame.of(points), 0.9, marks)


def judged(picture, medium="flat"):
    return JudgedPicture(picture, "one", medium, np.array([5.0, 60.0]))


def test_what_is_right_is_counted_as_right(picture):
    tally = DetectorTally()
    tally.add(judged(picture), Detection([found(points) for points in picture.landmarks], picture.regions))
    figures = tally.figures
    assert (figures["faces"], figures["recall"], figures["precision"], figures["failed"]) == (2, 1, 1, 0)
    assert figures["nme"]["all"] == 0 and figures["iou"]["mean"] == 1
    assert figures["media"]["flat"] == {"faces": 2, "found": 2, "nme": 0}
    assert [figures["yaws"][name]["faces"] for name in ("to 20", "to 90")] == [1, 1]
    assert 0 < figures["mean_shape"]["all"] < 5


def test_missed_and_false_faces_and_wrong_pixels_count(picture):
    elsewhere = picture.landmarks[0] * 0.5
    regions = np.zeros_like(picture.regions)
    tally = DetectorTally()
    tally.add(judged(picture), Detection([found(elsewhere), found(picture.landmarks[1])], regions))
    figures = tally.figures
    assert (figures["recall"], figures["precision"], figures["false"], figures["failed"]) == (0.5, 0.5, 1, 0.5)
    assert figures["iou"]["skin"] == 0 and 0.3 < figures["iou"]["background"] < 1


def test_errors_are_shares_of_the_diagonal_and_spreads_are_told_by_them(picture):
    generator = np.random.default_rng(0)
    tally = DetectorTally()
    for _ in range(20):
        noisy = [points + generator.normal(0, 2, points.shape) for points in picture.landmarks]
        tally.add(judged(picture), Detection([found(points) for points in noisy], picture.regions))
    assert tally.trust == pytest.approx(2, rel=0.05)
    calm = tally.trusting(2.0).figures["within"]
    assert calm["along"] == pytest.approx(0.68, abs=0.03) and calm["across"] == pytest.approx(0.68, abs=0.03)
    diagonal = np.mean([np.linalg.norm(np.ptp(points[:68], axis=0)) for points in picture.landmarks])
    # The mean length of two normal numbers of deviation 2.
    assert tally.figures["nme"]["all"] == pytest.approx(100 * 2 * np.sqrt(np.pi / 2) / diagonal, rel=0.1)


def test_faces_mostly_beyond_the_edge_are_not_asked_for(picture):
    from dataclasses import replace

    shifted = replace(picture, landmarks=picture.landmarks + [0, 110], visible=picture.visible)
    tally = DetectorTally()
    tally.add(judged(shifted), Detection([], picture.regions))
    assert tally.figures["faces"] == 0 and tally.figures["recall"] == 0
    tally.add(judged(shifted), Detection([found(shifted.landmarks[0])], picture.regions))
    assert tally.figures["false"] == 0
