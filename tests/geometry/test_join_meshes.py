"""Several meshes as one."""

import numpy as np

from caricli.geometry.join_meshes import join_meshes
from caricli.structures import Mesh

SQUARE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
TRIANGLE = Mesh(
    np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]), np.array([[0, 1, 2]]), np.eye(3, 2), np.array([[2, 1, 0]])
)


def test_polygons_keep_their_corners_and_their_places():
    both = join_meshes([SQUARE, TRIANGLE])
    assert both.polygons.tolist() == [[0, 1, 2, 3], [4, 5, 6, -1]]
    np.testing.assert_array_equal(both.vertices, np.concatenate([SQUARE.vertices, TRIANGLE.vertices]))
    np.testing.assert_array_equal(both.uvs[both.uv_polygons[1, :3]], TRIANGLE.uvs[TRIANGLE.uv_polygons[0]])
    assert len(set(both.uv_polygons[0])) == 1


def test_where_none_has_uvs_there_are_none():
    both = join_meshes([SQUARE, SQUARE])
    assert both.uvs is None and both.polygons.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]


def test_one_alone_stays_as_it_is():
    same = join_meshes([TRIANGLE])
    assert same.topology_id == TRIANGLE.topology_id and same.same_layout(TRIANGLE)
