import numpy as np
import pytest

from caricli.geometry.lines.match_line import match_line, resample

TURN = np.linspace(0, np.pi, 15)
ARC = np.stack([20 * np.cos(TURN), 8 * np.sin(TURN)], 1)


def dense(line, count=200):
    return resample(line, count)


def test_resampled_points_are_equally_far_apart_and_keep_the_ends():
    line = np.array([[0.0, 0], [3, 0], [3, 1]])
    points = resample(line, 5)
    np.testing.assert_allclose(points, [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1]])


@pytest.mark.parametrize("whole", [True, False])
def test_a_line_on_itself_stays(whole):
    np.testing.assert_allclose(match_line(ARC, dense(ARC), whole), ARC, atol=0.4)


def test_a_whole_line_may_be_drawn_larger_and_elsewhere():
    def bigger(points):
        return points * [1.4, 1.8] + [30, -10]

    np.testing.assert_allclose(match_line(ARC, dense(bigger(ARC)), whole=True), bigger(ARC), atol=1.0)


def test_corners_meet_corners():
    """By the share of the length alone the corner would be met four units too late."""
    corner = resample(np.array([[0.0, 0], [8, 0], [8, 8]]), 11)
    drawn = np.array([[0.0, 0], [8, 0], [8, 16]])
    places = match_line(corner, dense(drawn), whole=True)
    assert np.linalg.norm(places - [8, 0], axis=1).min() < 1 and np.linalg.norm(places[4:6] - [8, 0], axis=1).max() < 3
    assert np.linalg.norm(resample(drawn, 11)[5] - [8, 0]) == pytest.approx(4)


def test_what_was_not_drawn_has_no_place():
    places = match_line(ARC, dense(ARC[3:11]), whole=False)
    assert np.isnan(places[:2]).all() and np.isnan(places[12:]).all()
    np.testing.assert_allclose(places[4:10], ARC[4:10], atol=0.8)


def test_places_keep_their_order_on_a_shaky_line():
    generator = np.random.default_rng(3)
    drawn = dense(ARC, 60) + generator.normal(0, 0.3, (60, 2))
    places = match_line(ARC, drawn, whole=True)
    fine = resample(drawn, 2000)
    along = np.argmin(((places[:, None] - fine) ** 2).sum(-1), axis=1)
    assert (np.diff(along) > 0).all()


def test_a_line_far_longer_than_expected_is_used_whole():
    places = match_line(ARC, dense(10 * ARC), whole=False)
    assert np.isfinite(places).all()
    np.testing.assert_allclose(places[[0, -1]], 10 * ARC[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("part", [slice(0, 9), slice(4, 15), slice(2, 12)])
def test_a_line_from_its_other_end_has_the_same_places(whole, part):
    places = match_line(ARC, dense(ARC[part]), whole)
    back = match_line(ARC[::-1], dense(ARC[part])[::-1], whole)[::-1]
    np.testing.assert_array_equal(np.isnan(back), np.isnan(places))
    np.testing.assert_allclose(back, places, atol=0.4)


@pytest.mark.parametrize("whole", [True, False])
def test_a_line_far_from_the_corner_of_a_picture_has_the_same_places(whole):
    places = match_line(ARC, dense(ARC[2:12]), whole)
    moved = match_line(ARC + [30000, 40000], dense(ARC[2:12]) + [30000, 40000], whole)
    np.testing.assert_allclose(moved - [30000, 40000], places, atol=1e-6)


def test_a_straight_line_may_be_matched():
    line = np.stack([np.linspace(0, 8, 9), np.full(9, 2.0)], 1)
    np.testing.assert_allclose(match_line(line, dense(3 * line), whole=True), 3 * line, atol=0.6)


@pytest.mark.parametrize("whole", [True, False])
def test_a_curve_of_many_vertices_has_a_place_for_each(whole):
    turn = np.linspace(0, np.pi, 900)
    arc = np.column_stack([np.cos(turn), np.sin(turn)])
    places = match_line(arc, 100 * arc + 50, whole)
    assert np.isfinite(places).all()
    assert np.linalg.norm(places - (100 * arc + 50), axis=1).max() < 0.5
