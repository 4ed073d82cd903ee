import numpy as np
import pytest

from caricli.render.smooth_normals import even_normals, smooth_normals


def test_point_away_from_a_sphere(sphere):
    vertices, faces = sphere
    normals = smooth_normals(vertices, faces)
    assert (normals * vertices).sum(1).min() > 0.999


@pytest.mark.parametrize("normals_of", [smooth_normals, even_normals])
def test_a_split_seam_is_not_seen(sphere, normals_of):
    vertices, faces = sphere
    split = vertices[faces.ravel()]  # every triangle with corners of its own
    normals = normals_of(split, np.arange(len(split)).reshape(-1, 3))
    np.testing.assert_allclose(normals, normals_of(vertices, faces)[faces.ravel()], atol=1e-12)


@pytest.mark.parametrize("normals_of", [smooth_normals, even_normals])
def test_a_loose_vertex_and_a_triangle_without_area_give_zero(normals_of):
    normals = normals_of(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5.0, 5, 5]]), np.array([[0, 1, 2]]))
    assert (normals == 0).all()


def test_even_ones_are_the_slow_mean_over_triangles_and_turn_less_where_a_vertex_stands_out(sphere):
    vertices, faces = sphere
    bumpy = vertices.copy()
    bumpy[7] *= 1.1
    smooth, even = smooth_normals(bumpy, faces), even_normals(bumpy, faces)
    slow = np.array([smooth[faces[(faces == k).any(1)]].sum((0, 1)) for k in range(len(bumpy))])
    np.testing.assert_allclose(even, slow / np.linalg.norm(slow, axis=1, keepdims=True), atol=1e-12)
    beside = np.setdiff1d(faces[(faces == 7).any(1)], 7)
    turned = [(normals * vertices).sum(1)[beside].min() for normals in (smooth, even)]
    assert turned[0] < turned[1]
