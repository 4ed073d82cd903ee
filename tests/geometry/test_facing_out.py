import numpy as np
import pytest

from caricli.geometry.facing_out import facing_out


def test_a_ball_faces_out_of_every_place_within_it(ball):
    vertices, faces = ball
    for middle in ([0, 0, 0], [0.5, -0.3, 0.6]):
        assert facing_out(vertices, faces, np.array(middle)) == pytest.approx(1)
        assert facing_out(vertices, faces[:, ::-1], np.array(middle)) == pytest.approx(-1)
        assert facing_out(vertices * [-1, 1, 1], faces, np.array(middle)) == pytest.approx(-1)
    assert facing_out(1e-3 * vertices + 5, faces, np.full(3, 5.0)) == pytest.approx(1)


def test_torn_and_open_surfaces_face_as_whole_ones(ball):
    vertices, faces = ball
    upper = faces[vertices[faces][..., 1].min(1) > -0.3]
    torn = vertices[upper].reshape(-1, 3)
    assert facing_out(torn, np.arange(len(torn)).reshape(-1, 3), np.zeros(3)) == pytest.approx(1)


def test_what_faces_neither_way_is_between(ball):
    vertices, faces = ball
    within = np.concatenate([vertices, 0.5 * vertices])
    both = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    assert facing_out(within, both, np.zeros(3)) == pytest.approx((1 - 0.125) / (1 + 0.125))
    flat = vertices * [1, 1, 0]
    assert facing_out(flat, faces, np.zeros(3)) == 0
