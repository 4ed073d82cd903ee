import numpy as np
import pytest

from caricli.geometry.triangulate import triangulate
from caricli.io.face import read_face
from caricli.io.obj import ObjMesh, write_obj


def test_triangles_stay_as_they_are():
    assert triangulate([[0, 1, 2], [2, 1, 3]]).tolist() == [[0, 1, 2], [2, 1, 3]]
    assert triangulate([[0, 1, 2, -1], [2, 1, 3, -1]]).tolist() == [[0, 1, 2], [2, 1, 3]]


def test_a_quad_becomes_two_triangles_around_its_first_corner():
    assert triangulate([[4, 5, 6, 7]]).tolist() == [[4, 5, 6], [4, 6, 7]]


def test_the_vertex_zero_may_stand_anywhere():
    assert triangulate([[3, 2, 1, 0], [2, 1, 0, -1]]).tolist() == [[3, 2, 1], [3, 1, 0], [2, 1, 0]]


def test_mixed_polygons_become_fans_in_their_order():
    polygons = np.array([[0, 1, 2, 3, 4, 5], [6, 7, 8, -1, -1, -1], [2, 3, 9, 8, -1, -1]])
    before = polygons.copy()
    expected = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [6, 7, 8], [2, 3, 9], [2, 9, 8]]
    faces = triangulate(polygons)
    assert faces.tolist() == expected
    assert faces.dtype == np.int32 and faces.flags.c_contiguous
    assert np.array_equal(polygons, before)


@pytest.mark.parametrize("corners", [3, 4, 5, 9])
def test_the_area_of_a_regular_polygon_is_kept(corners):
    turn = 2 * np.pi * np.arange(corners) / corners
    points = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    faces = triangulate(np.arange(corners)[None])
    a, b, c = np.moveaxis(points[faces], 1, 0)
    u, v = b - a, c - a
    areas = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
    assert len(faces) == corners - 2 and (areas > 0).all()
    assert areas.sum() == pytest.approx(corners / 2 * np.sin(2 * np.pi / corners))


def test_a_face_read_from_an_obj_has_the_same_triangles(tmp_path):
    polygons = np.array([[0, 1, 2, 3, 4], [0, 4, 5, -1, -1], [5, 4, 3, 2, -1]], np.int32)
    vertices = np.random.default_rng(0).normal(size=(6, 3))
    write_obj(tmp_path / "mesh.obj", ObjMesh(vertices, polygons, None, None))
    face = read_face(tmp_path / "mesh.obj")
    assert np.array_equal(face.faces, triangulate(polygons))
    assert np.array_equal(triangulate(face.polygons), triangulate(polygons))


def test_the_head_is_made_of_the_triangles_of_its_quads(head, head_template):
    assert np.array_equal(head_template.faces, triangulate(head.polygons))
