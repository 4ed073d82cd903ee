import numpy as np
import pytest

from caricli.render.coat import Coat, mesh_coat
from caricli.render.shade import Look, shade
from caricli.structures import Material, Mesh, Pictures

SIDE = 40


@pytest.fixture
def wall():
    """Two triangles that fill a picture of 40 x 40 pixels, lying in a picture as they lie there."""
    points = np.array([[0, 0, 5], [0, SIDE, 5], [SIDE, SIDE, 5], [SIDE, 0, 5.0]]) - [0.5, 0.5, 0]
    uvs = np.array([[0, 1], [0, 0], [1, 0], [1, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(points, faces, uvs, faces)


def test_a_pixel_has_the_colour_of_its_place(wall):
    picture = np.zeros((SIDE, SIDE, 3), np.uint8)
    picture[: SIDE // 2, :, 0] = 230
    picture[:, : SIDE // 2, 1] = 230
    drawn = shade(wall.vertices, wall.faces, SIDE, SIDE, Look(coat=mesh_coat(wall, Pictures(picture))))
    for channel in (0, 1):
        bright = drawn[..., channel] > 128
        assert (bright[2:-2, 2:-2] == (picture[..., channel] > 0)[2:-2, 2:-2]).mean() > 0.99


def test_materials_have_their_pictures_and_what_has_none_its_own_colour(wall):
    red = np.full((8, 8, 3), [230, 10, 10], np.uint8)
    coat = mesh_coat(wall, Pictures(eyes=red), np.array([Material.SKIN, Material.EYE]))
    drawn = shade(wall.vertices, wall.faces, SIDE, SIDE, Look(colour=(10, 200, 10), coat=coat)).astype(int)
    lower, upper = drawn[30, 8], drawn[8, 30]
    assert lower[1] > lower[0] + 60 and upper[0] > upper[1] + 60


def test_vertices_on_a_seam_are_doubled_and_no_others():
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    coat = Coat(np.arange(12.0).reshape(6, 2), np.array([[0, 1, 2], [0, 4, 3]]), np.zeros(2, int), Pictures())
    at, cut, places = coat.cut(faces)
    assert sorted(at) == [0, 1, 2, 2, 3]
    np.testing.assert_array_equal(at[cut], faces)
    np.testing.assert_array_equal(places[cut][..., :2], coat.uvs[coat.uv_faces])


def test_pictures_are_shrunk_where_texels_are_smaller_than_pixels(wall):
    for side, expected in ((16, 16), (SIDE, SIDE), (SIDE * 2, SIDE), (SIDE * 9, SIDE)):
        coat = mesh_coat(wall, Pictures(np.zeros((side, side, 3), np.uint8)))
        small = coat.shrunk(wall.vertices, wall.faces)
        assert small.pictures.skin.shape == (expected, expected, 3)
        assert all(picture is None for name, picture in small.pictures.items() if name != "skin")
        # Once is enough.
        assert small.shrunk(wall.vertices, wall.faces).pictures.skin is small.pictures.skin


def test_eyeballs_beside_the_mesh_are_painted(wall):
    blue = np.full((64, 64, 3), [10, 10, 230], np.uint8)
    look = Look(eyeballs=[(np.array([20.0, 20, 2]), 8.0)], coat=mesh_coat(wall, Pictures(eyes=blue)))
    drawn = shade(wall.vertices, wall.faces, SIDE, SIDE, look).astype(int)
    assert drawn[24, 22, 2] > drawn[24, 22, 0] + 60


def test_no_pictures_or_uvs_are_no_coat(wall):
    assert mesh_coat(wall, Pictures()) is None
    assert mesh_coat(Mesh(wall.vertices, wall.faces), Pictures(np.zeros((2, 2, 3), np.uint8))) is None


def test_vertices_are_doubled_where_materials_meet_at_one_place_of_the_pictures():
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    materials = np.array([Material.SKIN, Material.EYE])
    coat = Coat(np.arange(8.0).reshape(4, 2), faces, materials, Pictures())
    at, cut, places = coat.cut(faces)
    assert sorted(at) == [0, 0, 1, 2, 2, 3]
    np.testing.assert_array_equal(at[cut], faces)
    np.testing.assert_array_equal(places[cut][..., 2], materials[:, None] * [1, 1, 1])


def test_wide_pictures_are_shrunk_by_their_area_and_keep_some_colours(wall):
    coat = mesh_coat(wall, Pictures(np.zeros((SIDE * 2, SIDE * 8, 3), np.uint8)))
    # 16 texels for every pixel: four times smaller along either side.
    assert coat.shrunk(wall.vertices, wall.faces).pictures.skin.shape == (SIDE // 2, SIDE * 2, 3)
    far = mesh_coat(wall, Pictures(np.zeros((320, 320, 3), np.uint8))).shrunk(1e-3 * wall.vertices, wall.faces)
    assert far.pictures.skin.shape == (16, 16, 3)


def test_a_picture_of_eyeballs_alone_is_as_fine_as_they_are_large(wall):
    """Its width goes once around the ball."""
    coat = mesh_coat(wall, Pictures(eyes=np.zeros((1024, 1024, 3), np.uint8)))
    for radius in (10.0, 40.0):
        side = coat.shrunk(wall.vertices, wall.faces, radius).pictures.eyes.shape[0]
        assert abs(side - 2 * np.pi * radius) < 2
