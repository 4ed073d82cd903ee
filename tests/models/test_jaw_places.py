import numpy as np

from caricli.geometry.lines.space_jaw import jaw_shares, space_jaw
from caricli.models.detector.jaw_places import JawPlaces, face_shape
from caricli.models.detector.usual_shapes import UsualShapes
from tests.drawn_pictures import mean_shape


def test_the_shape_of_a_face_does_not_depend_on_where_it_is(head_template):
    shape = mean_shape(head_template)
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    np.testing.assert_allclose(face_shape(3 * shape @ turn.T + [50, -20]), face_shape(shape), atol=1e-9)
    assert np.linalg.norm(np.ptp(face_shape(shape).reshape(68, 2), axis=0)) == 1


def test_without_knowledge_jaws_are_marked_at_equal_distances(head_template):
    shape = mean_shape(head_template)
    np.testing.assert_allclose(JawPlaces.even().mark(shape), space_jaw(space_jaw(shape)), atol=1e-9)


def test_points_go_where_the_map_says_and_no_farther_than_ear_and_chin(head_template):
    shape = mean_shape(head_template)
    bias = np.tile(np.linspace(0, 1, 9)[1:-1] ** 1.5, 2)
    marked = JawPlaces(np.zeros((14, 136)), bias).mark(shape)
    assert np.abs(jaw_shares(marked)[:, 1:-1].ravel() - bias).max() < 0.01
    np.testing.assert_allclose(marked[[0, 8, 16]], shape[[0, 8, 16]], atol=1e-9)
    np.testing.assert_array_equal(marked[17:], shape[17:])
    wild = JawPlaces(np.random.default_rng(0).normal(size=(14, 136)), bias).mark(shape)
    shares = jaw_shares(wild)
    assert (np.diff(shares, axis=1) >= 0).all() and np.isfinite(wild).all()


def test_jaws_of_usual_faces_are_marked_evenly_and_of_strange_ones_as_told(head_template):
    shape = mean_shape(head_template)
    bias = np.tile(np.linspace(0, 1, 9)[1:-1] ** 1.5, 2)
    middle = face_shape(space_jaw(shape))
    axes = np.eye(136)[:2]
    for away, share in ((0.0, 0.0), (1.5, 0.0), (3.0, 1.0), (40.0, 1.0)):
        # All that is left of the face beside the axes is as far as this.
        aside = np.zeros(136)
        aside[50] = np.sqrt(2 * 134 * away) * 1e-3
        places = JawPlaces(np.zeros((14, 136)), bias, UsualShapes(middle + aside, axes, np.full(3, 1e-3)))
        even = JawPlaces.even().bias
        found = jaw_shares(places.mark(shape))[:, 1:-1].ravel()
        assert np.abs(found - (even + share * (bias - even))).max() < 0.01
