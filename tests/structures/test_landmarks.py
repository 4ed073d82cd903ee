import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Landmarks, landmarks

NAN = float("nan")


def circle(count=68):
    angles = np.linspace(0, 6, count)
    return np.stack([100 + 50 * np.cos(angles), 120 + 50 * np.sin(angles)], axis=1)


def with_point(k, value, count=68):
    points = circle(count)
    points[k] = value
    return points


def with_slide(k, value):
    slides = np.zeros((68, 2))
    slides[k] = value
    return slides


def test_known_points_and_their_diagonal():
    points = with_point([0, 5], NAN)
    marks = Landmarks(points)
    assert marks.known.sum() == 66 and not marks.known[[0, 5]].any()
    extent = np.ptp(points[marks.known], axis=0)
    assert marks.diagonal == pytest.approx(np.hypot(*extent))
    assert Landmarks(2 * points + 7).diagonal == pytest.approx(2 * marks.diagonal)


def test_both_layouts_and_integers():
    assert Landmarks(circle(81)).points.shape == (81, 2)
    assert Landmarks(circle().astype(int)).points.dtype == np.float64


def test_points_of_the_head_are_where_points_slide_to():
    marks = Landmarks(with_point(5, NAN, 81), slides=np.full((81, 2), 2.0))
    np.testing.assert_array_equal(marks.head_points, marks.points + 2)
    assert marks.first(68).slides.shape == (68, 2) and np.isnan(marks.head_points[5]).all()
    plain = Landmarks(circle())
    assert plain.head_points is plain.points


@pytest.mark.parametrize(
    ("slides", "words"),
    [
        (np.zeros((68, 3)), "expected a slide of every point, found"),
        (np.zeros((67, 2)), "expected a slide of every point, found"),
        (with_slide(3, NAN), "point 3: expected a slide no farther than the face is large, found"),
        (with_slide(7, [0, -200]), "point 7: expected a slide no farther than the face is large, found"),
    ],
)
def test_what_are_no_slides_is_refused(slides, words):
    with pytest.raises(InputError, match=words):
        Landmarks(circle(), slides=slides)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (circle(5), "expected 68 or 81 points, found 5"),
        (circle(67), "expected 68 or 81 points, found 67"),
        (np.zeros((68, 3)), "expected 68 or 81 points"),
        (circle().T, "expected 68 or 81 points, found 2"),
        (with_point(4, [1, np.inf]), r"point 4: expected finite coordinates, found \[1.0, inf\]"),
        (with_point(4, [1, NAN]), "point 4: expected finite coordinates"),
        (with_point(4, [1, 1e7]), "point 4: expected finite coordinates"),
        (np.full((68, 2), NAN), "at least 8 known points, found 0"),
        (np.concatenate([circle(7), np.full((61, 2), NAN)]), "at least 8 known points, found 7"),
        (circle() * 0 + 7, "all of them in one place"),
    ],
)
def test_what_are_no_landmarks_is_refused(points, words):
    with pytest.raises(InputError, match=words):
        Landmarks(points)


@pytest.mark.parametrize("scale", [1 / 512, 0.001, 3.0])
def test_landmarks_of_another_picture_are_refused(scale):
    points = np.random.default_rng(0).uniform(100, 400, (68, 2))
    Landmarks(points).check_inside((512, 512))
    Landmarks(points, (512, 512))
    with pytest.raises(InputError, match=r"^expected the landmarks of a face in the 512 x 512 image"):
        Landmarks(scale * points).check_inside((512, 512))
    with pytest.raises(InputError, match=r"^expected the landmarks of a face in the 512 x 512 image"):
        Landmarks(scale * points, (512, 512))


def test_a_point_may_lie_beside_the_picture_but_not_far_away():
    Landmarks(with_point(5, [-200, 600]), (200, 300))
    for place in ([-201, 100], [100, 601]):
        with pytest.raises(InputError, match="point 5: expected a place in or near the 200 x 300 image"):
            Landmarks(with_point(5, place), (200, 300))


def test_the_parts_are_all_points_once():
    numbers = [k for part in landmarks.PARTS.values() for k in part]
    assert numbers == list(range(81)) and landmarks.COUNT == 68
    finer = ("BROW_RIGHT", "BROW_LEFT", "BRIDGE", "NOSTRILS", "EYE_RIGHT", "EYE_LEFT", "LIPS", "LIPS_INSIDE")
    assert [k for name in finer for k in getattr(landmarks, name)] == list(range(17, 68))
    extra = ("FOREHEAD", "EAR_RIGHT", "EAR_LEFT", "CHEEKBONES", "TEMPLES")
    assert [k for name in extra for k in getattr(landmarks, name)] == list(range(68, 81))
    assert [*landmarks.BROWS] == [*landmarks.BROW_RIGHT, *landmarks.BROW_LEFT]
    assert [*landmarks.EYES] == [*landmarks.EYE_RIGHT, *landmarks.EYE_LEFT]


def test_the_lines_are_all_points_of_ibug_once():
    lines = (*landmarks.POLYLINES, *landmarks.RINGS)
    assert sorted(k for line in lines for k in line) == list(range(68))
    assert sorted(landmarks.OUTLINE) == [*landmarks.JAW, *landmarks.BROWS]


def test_pairs_and_lids_lie_where_their_names_say():
    for side, eye in (("left", landmarks.EYE_LEFT), ("right", landmarks.EYE_RIGHT)):
        upper = landmarks.UPPER_LID[side]
        lower = landmarks.LOWER_LID[side]
        assert {*upper, *lower} == {*eye} and (upper[0], upper[-1]) == (lower[0], lower[-1])
    assert {k for pair in landmarks.LID_PAIRS for k in pair} < {*landmarks.EYES}
    assert {k for pair in landmarks.LIP_PAIRS for k in pair} < {*landmarks.LIPS_INSIDE}
    for outer, inner in (
        (landmarks.UPPER_LIP, landmarks.UPPER_LIP_INSIDE),
        (landmarks.LOWER_LIP, landmarks.LOWER_LIP_INSIDE),
    ):
        assert {*outer} < {*landmarks.LIPS} and {*inner} < {*landmarks.LIPS_INSIDE}
        assert ((outer[0], inner[0]), (outer[-1], inner[-1])) == landmarks.MOUTH_CORNERS


def test_names_of_points():
    names = landmarks.POINT_NAMES
    assert set(names.values()) <= set(range(81))
    assert [names[name] for name in landmarks.EXTRA_NAMES] == [*landmarks.EXTRA]
    for name, number in names.items():
        side = name.rpartition("_")[2]
        part = {"brow": "BROW", "eye": "EYE", "ear": "EAR"}.get(name.partition("_")[0])
        if part and side in ("left", "right"):
            assert number in getattr(landmarks, f"{part}_{side.upper()}"), name
    assert names["chin"] in landmarks.JAW and names["nose_tip"] in landmarks.BRIDGE
