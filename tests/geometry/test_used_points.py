import numpy as np

from caricli.geometry.used_points import used_points


def test_corners_of_faces_are_used_and_all_vertices_where_there_are_none():
    vertices = np.arange(15.0).reshape(5, 3)
    np.testing.assert_array_equal(used_points(vertices, np.array([[4, 0, 2]])), vertices[[0, 2, 4]])
    np.testing.assert_array_equal(used_points(vertices, np.zeros((0, 3), int)), vertices)
