import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles


def push_across(vertices, faces, face, by=1.15):
    """Move one corner of a triangle across the middle of the opposite edge."""
    a, b, c = faces[face]
    pushed = vertices.copy()
    pushed[a] += by * ((vertices[b] + vertices[c]) / 2 - vertices[a])
    return pushed


def test_a_motion_or_affine_stretch_flips_nothing(ball_gradients):
    vertices = ball_gradients.template
    rotation = Rotation.from_rotvec([2.0, -1.0, 0.5]).as_matrix()
    for linear in (np.eye(3), rotation, np.diag([0.05, 1.0, 4.0]), rotation @ np.diag([3.0, 0.2, 1.0])):
        assert not flipped_triangles(vertices @ linear.T + [1.0, 2.0, 3.0], ball_gradients).any()


@pytest.mark.parametrize("face", [0, 74, 148, 296, 370, 444, 518])
def test_a_vertex_pushed_across_an_edge_turns_that_triangle_only(ball_gradients, face):
    vertices, faces = ball_gradients.template, ball_gradients.faces
    flipped = flipped_triangles(push_across(vertices, faces, face), ball_gradients)
    assert np.flatnonzero(flipped).tolist() == [face]


def test_what_is_flipped_does_not_depend_on_the_pose(ball_gradients):
    pushed = push_across(ball_gradients.template, ball_gradients.faces, 100)
    rotation = Rotation.from_rotvec([-0.7, 2.2, 1.0]).as_matrix()
    flipped = flipped_triangles(3 * pushed @ rotation.T + 1, ball_gradients)
    assert np.flatnonzero(flipped).tolist() == [100]


def test_leading_dimensions_are_batches(ball_gradients):
    vertices, faces = ball_gradients.template, ball_gradients.faces
    shapes = np.array([[vertices, push_across(vertices, faces, 3)], [push_across(vertices, faces, 50), 2 * vertices]])
    flipped = flipped_triangles(shapes, ball_gradients)
    assert flipped.shape == (2, 2, len(faces)) and flipped.dtype == bool
    assert flipped.sum(-1).tolist() == [[0, 1], [1, 0]]
    assert flipped[0, 1, 3] and flipped[1, 0, 50]


def test_bending_a_sheet_flips_nothing(patch):
    """Normals go far, yet none against its surroundings."""
    gradients = DeformationGradients(*patch)
    x, y, z = patch[0].T
    angle = 1.6 * (x - x.min()) / np.ptp(x)
    bent = np.stack([np.sin(angle) * (1 + z), y, np.cos(angle) * (1 + z)], axis=1)
    assert not flipped_triangles(bent, gradients).any()


def test_some_may_be_asked_for(ball_gradients):
    shape = push_across(ball_gradients.template, ball_gradients.faces, 100)
    whole = flipped_triangles(shape, ball_gradients)
    some = np.array([3, 100, 250])
    np.testing.assert_array_equal(flipped_triangles(shape, ball_gradients, some), [False, True, False])
    chosen = np.arange(len(whole)) % 4 == 0
    np.testing.assert_array_equal(flipped_triangles(shape, ball_gradients, chosen), whole[chosen])
