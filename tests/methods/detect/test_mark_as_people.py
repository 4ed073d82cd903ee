import numpy as np

from caricli.geometry.lines.space_jaw import jaw_shares, space_jaw
from caricli.methods.detect.mark_as_people import mark_as_people
from caricli.models.detector.jaw_places import JawPlaces
from caricli.structures import Landmarks
from tests.drawn_pictures import mean_shape

SHARES = np.linspace(0, 1, 9) ** 1.3
JAW = JawPlaces(np.zeros((14, 136)), np.tile(SHARES[1:-1], 2))


def seen(head_template):
    return Landmarks(200 + 300 * space_jaw(mean_shape(head_template)))


def test_points_slide_to_where_people_mark_them_and_those_of_the_head_stay(head_template):
    before = seen(head_template)
    marks = mark_as_people(before, JAW)
    np.testing.assert_allclose(marks.head_points, before.points, atol=1e-9)
    assert np.abs(jaw_shares(marks.points) - SHARES).max() < 0.01
    moved = np.linalg.norm(marks.slides, axis=1) / before.diagonal
    assert (moved[[0, 8, 16, 36, 48, 54]] < 1e-12).all() and (moved[[4, 18, 28, 49, 55]] > 0.001).all()
    assert moved.max() < 0.1


def test_a_jaw_of_a_face_that_is_not_all_known_stays(head_template):
    before = seen(head_template)
    before.points[[3, 40]] = np.nan
    marks = mark_as_people(before, JAW)
    np.testing.assert_array_equal(marks.points[:17], before.points[:17])
    np.testing.assert_array_equal(np.isnan(marks.head_points), np.isnan(before.points))
    assert (marks.points[18] != before.points[18]).any() and np.isfinite(marks.slides).all()
