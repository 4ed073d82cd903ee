import numpy as np
import pytest

from caricli.render.draw_textured import ANGLES, INSIDE, draw_textured, render_textured
from caricli.structures import Material, Mesh, Pictures, Rig

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


def test_paper_and_shade(ball):
    where = placed(ball.neutral, 40, 49.5)
    image = render_textured(ball, where, 100, 100, paper=np.array([255.0, 0, 255]))
    assert image[2, 2].tolist() == [255, 0, 255]
    plain, shaded = render_textured(ball, where, 100, 100), render_textured(ball, where, 100, 100, shade=0.5)
    # In the middle the surface faces the viewer; at the edge it turns away and is half as bright.
    assert near(shaded[50, 52], plain[50, 52], 2)
    assert near(shaded[50, 88], 0.5 * plain[50, 88].astype(float), 25) and (shaded <= plain).all()


def test_views_are_from_where_they_say(ball):
    front, left, behind = draw_textured(ball, ["front", "profile", "behind"], 60)
    assert front.shape == behind.shape == (60, 60, 3) and set(ANGLES) >= {"front", "three-quarter", "profile", "behind"}

    def hue(image, colour):
        shares = image / np.maximum(image.sum(-1, keepdims=True), 1)
        return (np.abs(shares - np.array(colour) / sum(colour)).max(-1) < 0.03).mean()

    assert hue(front, LEFT) > 0.2 and hue(front, RIGHT) > 0.2 and hue(front, BACK) < 0.01
    assert hue(behind, BACK) > 0.5 and hue(behind, LEFT) < 0.02 and hue(behind, RIGHT) < 0.02
    assert hue(left, BACK) > 0.1 and abs(hue(left, LEFT) - hue(left, RIGHT)) > 0.1
    assert (front[0, 0] == WHITE).all()


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
