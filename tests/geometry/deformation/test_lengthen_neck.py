import numpy as np
import pytest

from caricli.geometry.deformation.lengthen_neck import CLEARANCE, Neck


@pytest.fixture(scope="module")
def sunken(head_template):
    """The template with everything near its chin 6 cm lower, far below the neck's edge."""
    vertices = np.array(head_template.vertices)
    distance = np.linalg.norm(vertices - vertices[head_template.neck.chin], axis=1)
    vertices[:, 1] -= 0.06 * np.exp(-((distance / 0.04) ** 2))
    return vertices


def test_a_usual_head_stays_as_it_is(head_template):
    np.testing.assert_array_equal(head_template.neck.lengthen(head_template.vertices), head_template.vertices)


def test_the_edge_goes_below_a_chin_that_sank(head_template, sunken):
    neck = head_template.neck
    assert sunken[neck.chin, 1] < sunken[neck.front, 1]
    longer = neck.lengthen(sunken)
    above = longer[neck.chin, 1] - longer[neck.front, 1]
    np.testing.assert_allclose(above, CLEARANCE * head_template.height, atol=1e-5)
    np.testing.assert_allclose(neck.lengthen(longer), longer, atol=1e-5)


def test_the_face_stays_and_nothing_jumps(head_template, sunken):
    moved = head_template.neck.lengthen(sunken) - sunken
    assert np.abs(moved[head_template.annotation.landmarks]).max() < 1e-6
    assert np.abs(moved[head_template.mask("ear_left", "ear_right", "nose", "lips", "forehead")]).max() < 1e-5
    assert np.abs(moved[:, [0, 2]]).max() == 0
    weights = head_template.neck.weights
    mirror = head_template.annotation.mirror
    np.testing.assert_allclose(weights, weights[mirror], atol=0.02)
    edges = np.concatenate([head_template.faces[:, [0, 1]], head_template.faces[:, [1, 2]]])
    assert np.abs(np.diff(weights[edges], axis=1)).max() < 0.6


def test_a_head_without_a_neck_has_nothing_to_lengthen(head_template, sunken):
    none = np.zeros(0, np.int64)
    still = np.zeros(len(head_template.vertices), bool)
    neck = Neck(head_template.vertices, head_template.faces, none, head_template.neck.chin, still)
    np.testing.assert_array_equal(neck.lengthen(sunken), sunken)


def test_a_neck_becomes_so_many_times_as_wide_about_its_edge_and_goes_to_its_place(head_template):
    neck, vertices = head_template.neck, head_template.vertices
    shift = np.array([0.01, -0.02, 0.005])
    wide = neck.widen(vertices, 1.5, shift)
    edge = vertices[neck.edge]
    np.testing.assert_allclose(wide[neck.edge], edge.mean(0) + 1.5 * (edge - edge.mean(0)) + shift, atol=1e-6)
    face = head_template.annotation.landmarks
    np.testing.assert_allclose(wide[face], vertices[face], atol=1e-6)
    np.testing.assert_array_equal(neck.widen(vertices, 1.0, np.zeros(3)), vertices)


def test_the_chin_keeps_half_of_its_usual_way_to_the_edge(head_template, sunken):
    neck = head_template.neck
    longer = neck.lengthen(sunken)
    usual, left = (shape[neck.chin, 1] - shape[neck.front, 1] for shape in (head_template.vertices, longer))
    assert 0.3 * usual < left < 0.7 * usual
