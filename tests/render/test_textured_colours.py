import numpy as np
import pytest

from caricli.render.textured_colours import INSIDE, textured_colours
from caricli.structures import Material, Mesh, Pictures, Rig
from tests.textured_pictures import render_textured

# Of pictures that are one colour on every side.
LEFT, RIGHT, BACK, WHITE = (200, 30, 40), (30, 180, 60), (60, 70, 220), 255


@pytest.fixture(scope="module")
def ball(sphere):
    """A ball whose picture is unrolled around it: u is the angle about y, from behind; three colours, three sides."""
    vertices, faces = sphere
    corners = vertices[faces].reshape(-1, 3)
    middle = np.repeat(vertices[faces].mean(1), 3, axis=0)
    turn, own = (np.arctan2(p[:, 0], p[:, 2]) for p in (middle, corners))
    # Corners of a triangle stay together over the seam.
    own = turn + np.angle(np.exp(1j * (own - turn)))
    uvs = np.stack([(own / (2 * np.pi) + 0.5), (corners[:, 1] + 1) / 2], axis=1)
    texture = np.zeros((16, 120, 3), np.uint8)
    texture[:, :30] = texture[:, 90:] = BACK
    texture[:, 30:60], texture[:, 60:90] = LEFT, RIGHT
    uv_faces = np.arange(len(uvs)).reshape(-1, 3).astype(np.int32)
    still = np.zeros((0, len(vertices), 3), np.float32)
    return Rig((), Mesh(vertices.astype(np.float32), faces, uvs, uv_faces), still, pictures=Pictures(texture))


def placed(vertices, scale, centre):
    """From +z, in pixels."""
    return vertices * [scale, -scale, -scale] + [centre, centre, 0]


def near(colour, wanted, tolerance=6):
    return np.abs(np.asarray(colour, float) - wanted).max() <= tolerance


def test_colours_are_where_the_uvs_say(ball):
    before = ball.pictures.skin.copy()
    image = render_textured(ball, placed(ball.neutral, 40, 49.5), 100, 100)
    assert image.shape == (100, 100, 3) and image.dtype == np.uint8
    assert near(image[50, 30], LEFT, 0) and near(image[50, 70], RIGHT, 0)
    assert (image[2, 2] == WHITE).all()
    np.testing.assert_array_equal(ball.pictures.skin, before)


def test_colours_are_no_whole_numbers_whatever_the_paper_is(ball):
    colours = textured_colours(ball, placed(ball.neutral, 40, 49.5), 100, 100, paper=(255, 0, 255))
    assert colours.dtype == np.float64 and (colours % 1 > 0).any()


def test_what_has_no_picture_has_the_colour_of_the_paper(ball):
    materials = np.full(len(ball.faces), Material.TEETH, np.int32)
    bare = Rig((), ball.mesh, ball.deltas, materials, ball.pictures)
    image = render_textured(bare, placed(ball.neutral, 40, 49.5), 100, 100, paper=(10, 120, 30))
    assert (image == (10, 120, 30)).all()


def test_paper_is_behind(ball):
    image = render_textured(ball, placed(ball.neutral, 40, 49.5), 100, 100, paper=np.array([255.0, 0, 255]))
    assert image[2, 2].tolist() == [255, 0, 255]


def test_eyes_have_their_own_picture_and_none_is_paper(ball):
    eyes = np.full((4, 4, 3), 77, np.uint8)
    materials = np.where(ball.neutral[ball.faces].mean(1)[:, 1] > 0, Material.EYE, Material.SKIN).astype(np.int32)
    both = Rig((), ball.mesh, ball.deltas, materials, Pictures(ball.pictures.skin, eyes))
    image = render_textured(both, placed(ball.neutral, 40, 49.5), 100, 100)
    assert (image[30, 40] == 77).all() and near(image[70, 30], LEFT, 0)
    bare = Rig((), ball.mesh, ball.deltas)
    assert (render_textured(bare, placed(ball.neutral, 40, 49.5), 100, 100) == WHITE).all()


def test_the_inside_has_no_picture(ball):
    turned = Mesh(ball.neutral, ball.faces[:, ::-1], ball.mesh.uvs, ball.mesh.uv_polygons[:, ::-1])
    inside = Rig((), turned, ball.deltas, pictures=Pictures(ball.pictures.skin))
    image = render_textured(inside, placed(ball.neutral, 40, 49.5), 100, 100)
    assert (image[50, 50] == np.round(INSIDE)).all()
