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


def test_triangles_count_by_their_angles_however_they_are_cut():
    """The corner of a box: three faces at right angles, one of them cut into a fan of thin triangles."""
    turns = np.linspace(0, np.pi / 2, 7)
    fan = np.stack([np.cos(turns), np.sin(turns), 0 * turns], 1)
    vertices = np.vstack([np.array([[0.0, 0, 0], [0, 0, 1]]), fan])
    thin = [[0, 2 + k, 3 + k] for k in range(6)]
    normals = smooth_normals(vertices, np.array([*thin, [0, 1, 2], [0, 8, 1]]))
    np.testing.assert_allclose(normals[0], np.ones(3) / np.sqrt(3), atol=1e-12)


def test_a_zero_is_at_the_place_of_a_negative_one():
    first, second = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-0.0, 0, -0.0], [0, -1, 0], [0, 0, 1]]
    normals = smooth_normals(np.array([*first, *second]), np.array([[0, 1, 2], [3, 4, 5]]))
    np.testing.assert_array_equal(normals[0], normals[3])
    assert np.linalg.norm(normals[0] - normals[1]) > 0.1
