import numpy as np

from caricli.geometry.triangle_normals import triangle_normals


def test_direction_and_length_are_normal_and_twice_the_area():
    vertices = np.array([[0.0, 0, 0], [3, 0, 0], [0, 2, 0], [0, 0, 1]])
    normals = triangle_normals(vertices, np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0]]))
    assert np.allclose(normals, [[0, 0, 6], [2, 0, 0], [0, 0, -6]])


def test_the_normals_of_a_closed_surface_sum_to_zero_and_point_outwards(ball):
    normals = triangle_normals(*ball)
    assert np.abs(normals.sum(0)).max() < 1e-12
    assert ((normals * ball[0][ball[1][:, 0]]).sum(1) > 0).all()


def test_leading_dimensions_are_batches(ball):
    shapes = np.stack([ball[0], 2 * ball[0]])[None]
    normals = triangle_normals(shapes, ball[1])
    assert normals.shape == (1, 2, len(ball[1]), 3)
    assert np.allclose(normals[0, 1], 4 * normals[0, 0])
