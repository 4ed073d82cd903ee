import numpy as np

from caricli.render.smooth_normals import smooth_normals


def test_point_away_from_a_sphere(sphere):
    vertices, faces = sphere
    normals = smooth_normals(vertices, faces)
    assert (normals * vertices).sum(1).min() > 0.999


def test_a_split_seam_is_not_seen(sphere):
    vertices, faces = sphere
    split = vertices[faces.ravel()]  # every triangle with corners of its own
    normals = smooth_normals(split, np.arange(len(split)).reshape(-1, 3))
    np.testing.assert_allclose(normals, smooth_normals(vertices, faces)[faces.ravel()], atol=1e-12)


def test_a_loose_vertex_and_a_triangle_without_area_give_zero():
    normals = smooth_normals(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5.0, 5, 5]]), np.array([[0, 1, 2]]))
    assert (normals == 0).all()
