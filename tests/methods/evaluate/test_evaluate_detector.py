from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_detector import UNKNOWN, DetectorTally, JudgedPicture
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import Landmarks
from tests.drawn_pictures import drawn_picture, mean_shape


@pytest.fixture(scope="module")
def picture(head_template):
    return drawn_picture(mean_shape(head_template), np.random.default_rng(2), faces=2)


def found(points, variance=1.0):
    marks = Landmarks(points, None, np.tile(variance * np.eye(2), (81, 1, 1)))
    return DetectedFace(FaceFrame.of(points), 0.9, marks)


def diagonal(points):
    return np.linalg.norm(np.ptp(points[:68], axis=0))


def tallied(picture, *faces, yaws=(5.0, 60.0)):
    """A tally of one picture in which faces were found."""
    tally = DetectorTally()
    tally.add(JudgedPicture(picture, "one", "flat", np.array(yaws)), Detection([*faces], picture.regions))
    return tally


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


def test_faces_of_which_what_is_seen_is_not_known_tell_nothing_of_spreads(picture):
    visible = np.arange(picture.visible.shape[1]) < 30
    half = replace(picture, visible=np.broadcast_to(visible, picture.visible.shape))
    points = [np.where(visible[:, None], np.nan, own) for own in picture.landmarks]
    pairs = zip(picture.landmarks, points, strict=True)
    faces = [replace(found(own), landmarks=found(some).landmarks) for own, some in pairs]
    tally = DetectorTally()
    tally.add(judged(half), Detection(faces, picture.regions))
    assert tally.trust == 1 and tally.figures["recall"] == 1 and tally.figures["within"] is None
    # Of jaw and brows nothing is known, of the nose a part.
    assert set(tally.figures["nme"]) == {"nose", "eyes", "mouth", "extra", "all"}
    assert max(tally.figures["nme"].values()) < 1e-9


def test_faces_mostly_beyond_the_edge_are_not_asked_for(picture):
    shifted = replace(picture, landmarks=picture.landmarks + [0, 110], visible=picture.visible)
    tally = DetectorTally()
    tally.add(judged(shifted), Detection([], picture.regions))
    assert tally.figures["faces"] == 0 and tally.figures["recall"] == 0
    tally.add(judged(shifted), Detection([found(shifted.landmarks[0])], picture.regions))
    assert tally.figures["false"] == 0


def test_precision_is_of_what_was_found_and_recall_of_what_is_there(picture):
    first, second = picture.landmarks
    figures = tallied(picture, found(first), found(second), found(second + [0, -90])).figures
    assert (figures["recall"], figures["precision"], figures["false"]) == (1, pytest.approx(2 / 3), 1)


def test_of_faces_found_in_one_place_the_nearest_counts_and_each_only_once(picture):
    first, second = picture.landmarks
    shift = [0.1 * diagonal(first), 0]
    figures = tallied(picture, found(first + shift), found(first)).figures
    assert (figures["false"], figures["recall"], figures["nme"]["all"]) == (1, 0.5, 0)
    both = replace(picture, landmarks=np.array([first, first + shift]))
    assert tallied(both, found(first)).figures["recall"] == 0.5


def test_a_face_fails_by_landmarks_that_are_far_off(picture):
    """One is 7 % off and counts, the other 9 %, and does not."""
    shifted = [
        points + [share * diagonal(points), 0] for points, share in zip(picture.landmarks, (0.07, 0.09), strict=True)
    ]
    figures = tallied(picture, *map(found, shifted)).figures
    assert (figures["recall"], figures["failed"]) == (1, 0.5)
    tally = tallied(picture, *map(found, picture.landmarks))
    tally.add(judged(picture), Detection([found(picture.landmarks[0]), found(shifted[1])], picture.regions))
    assert tally.figures["median"] == 0 and tally.figures["nme"]["all"] == pytest.approx(9 / 4)


def test_the_error_is_of_the_landmarks_of_ibug_alone(picture):
    moved = picture.landmarks.copy()
    moved[:, 68:] += 5
    assert tallied(picture, *map(found, moved)).figures["nme"]["all"] == 0


def test_landmarks_that_are_said_to_be_not_known_are_counted_for_each_face(picture):
    points = picture.landmarks.copy()
    points[0, [3, 40, 75]] = np.nan
    faces = [
        replace(found(whole), landmarks=Landmarks(p, None, np.tile(np.eye(2), (81, 1, 1))))
        for whole, p in zip(picture.landmarks, points, strict=True)
    ]
    figures = tallied(picture, *faces).figures
    assert figures["unknown"] == 1.5 and figures["nme"]["all"] == 0


def test_calibration_is_of_visible_landmarks_along_the_axes_of_their_spreads(picture):
    """Errors of five and a half pixels along a spread of ten by two that stands aslant."""
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    spreads = np.tile(turn @ np.diag([100.0, 4.0]) @ turn.T, (81, 1, 1))
    spreads = (spreads + spreads.transpose(0, 2, 1)) / 2
    hidden = np.arange(81) < 30
    seen = replace(picture, visible=np.tile(~hidden, (2, 1)))

    def within(way):
        marks = [points + turn @ way + 90 * hidden[:, None] for points in picture.landmarks]
        frames = map(FaceFrame.of, picture.landmarks)
        faces = [DetectedFace(at, 0.9, Landmarks(p, None, spreads)) for at, p in zip(frames, marks, strict=True)]
        return tallied(seen, *faces).figures["within"]

    assert within([5.5, 0]) == {"along": 1, "across": 1}
    assert within([5.5, 3]) == {"along": 1, "across": 0}
    assert within([11, 0]) == {"along": 0, "across": 1}


def test_pixels_of_which_nothing_is_known_do_not_count(picture):
    regions = picture.regions.copy()
    regions[:40] = UNKNOWN
    tally = DetectorTally()
    tally.add(judged(replace(picture, regions=regions)), Detection([], picture.regions))
    assert tally.figures["iou"]["mean"] == 1 and tally.confusion.sum() == (regions != UNKNOWN).sum()


def test_poses_are_told_apart_by_how_far_they_turn_to_either_side(picture):
    for yaws, names in (((-60.0, 120.0), {"to 90"}), ((-20.0, 21.0), {"to 20", "to 45"})):
        assert set(tallied(picture, yaws=yaws).figures["yaws"]) == names


def test_faces_that_are_hidden_or_small_are_not_asked_for(picture):
    hidden = picture.visible.copy()
    hidden[0, 20:] = False
    assert tallied(replace(picture, visible=hidden)).figures["faces"] == 1
    small = picture.landmarks.copy()
    small[0] = (small[0] - small[0].mean(0)) * 0.1 + 40
    assert tallied(replace(picture, landmarks=small)).figures["faces"] == 1


def test_the_mean_shape_is_the_mean_of_all_faces(picture):
    """Of two shapes each is as far from their mean as the other."""
    tally = tallied(picture)
    shapes = np.array([face.shape for face in tally.faces])
    apart = np.linalg.norm(shapes[0] - shapes[1], axis=1).mean() / 2
    shares = [100 * apart / diagonal(shape) for shape in shapes]
    assert tally.figures["mean_shape"]["all"] == pytest.approx(np.mean(shares))


def test_landmarks_that_nobody_marked_tell_nothing_of_spreads(picture):
    unmarked = picture.landmarks.copy()
    unmarked[:, 68:] = np.nan
    faces = [found(points + 0.5) for points in picture.landmarks]
    tally = tallied(replace(picture, landmarks=unmarked), *faces)
    assert tally.figures["within"] == {"along": 1, "across": 1} and np.isfinite(tally.trust)
