from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.pictures.draw_sitter import draw_sitter, random_strands
from caricli.methods.pictures.eyes import Eyes
from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.piece import join_pieces, make_piece, seen_from_both_sides
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.sitter import Sitter
from caricli.methods.texture.estimate_light import harmonics
from caricli.render.sky import DIRECTIONS
from caricli.structures.parsing import Region

SIZE = 100
POSE = Pose(head_rotation(np.zeros(3)), 40.0, np.array([50.0, 50.0]), 0.0, np.zeros(3), 2.0)
EVEN = Sky(np.array([[0.0, 0.0, -1.0]]), np.zeros((1, 3)), np.ones(1), np.ones(3), np.ones(3))
GREY = np.full(3, 0.5)
PLAIN = np.ones((256, 256), np.float32)
SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
"""80 pixels wide in POSE, facing the camera."""


@pytest.fixture
def draw(head_template):
    """Draws a Piece that every light of the sky reaches alike."""

    def drawn(piece, normals=None, pose=POSE, sky=EVEN, strands=PLAIN, seed=0, reached=1.0, creases=None):
        count = len(piece.vertices)
        normals = np.tile([0.0, 0, 1], (count, 1)) if normals is None else normals
        transfer = np.full((count, len(DIRECTIONS)), reached / len(DIRECTIONS), np.float32)
        nobody = Eyes([], np.zeros(3), 0.5)
        sitter = Sitter(head_template, piece, normals, transfer, nobody, np.zeros((0, 3)), creases)
        return draw_sitter(sitter, pose, SIZE, sky, strands, np.random.default_rng(seed))

    return drawn


def test_backs_are_seen_of_thin_things_alone(draw):
    points, faces = SQUARE
    for turned in (False, True):
        piece = make_piece(points, faces[:, ::-1] if turned else faces, Region.GLASSES, GREY)
        assert (draw(piece).region == Region.GLASSES).any() == (not turned)
        assert (draw(seen_from_both_sides(piece)).region == Region.GLASSES).sum() > 6000


def test_a_pixel_is_of_the_region_of_its_nearest_corner(draw):
    regions = np.array([Region.SKIN, Region.NOSE, Region.LIPS, Region.EARS])
    drawing = draw(make_piece(*SQUARE, regions, GREY))
    assert [drawing.region[at] for at in ((85, 15), (85, 85), (15, 85), (15, 15))] == regions.tolist()


@pytest.mark.parametrize("roll", [0.0, 2.0])
def test_gloss_mirrors_the_lamp_in_its_colour_where_light_arrives(ball, draw, roll):
    vertices, faces = ball
    pose = replace(POSE, rotation=head_rotation(np.array([0, 0.4, roll])))
    sky = replace(EVEN, ways=np.array([[-0.6, -0.8, 0.0]]), colours=np.array([[0.0, 0.4, 0]]))
    dull, glossy = (make_piece(vertices, faces, Region.SKIN, GREY, gloss) for gloss in (0.0, 0.5))
    shine = draw(glossy, vertices, pose, sky).colours - draw(dull, vertices, pose, sky).colours
    assert not shine[..., [0, 2]].any()
    rows, columns = np.nonzero(shine[..., 1] > 0.5 * shine[..., 1].max())
    np.testing.assert_allclose((np.array([columns.mean(), rows.mean()]) - 50) / 40, sky.half[:2], atol=0.12)
    assert 0.12 < shine.max() < 0.21
    shaded = [draw(piece, vertices, pose, sky, reached=0.1).colours for piece in (glossy, dull)]
    assert np.abs(shaded[0] - shaded[1]).max() < 0.2 * shine.max()


def test_some_have_dark_outlines_as_painters_do(ball, draw):
    vertices, faces = ball
    piece = make_piece(vertices, faces, Region.SKIN, GREY)
    darker = []
    for seed in range(60):
        light = draw(piece, vertices, seed=seed).colours.mean(2)
        assert light[45:56, 45:56] == pytest.approx(0.5, rel=1e-4) and light.max() < 0.501
        darker.append(light[50, 50 + 38] < 0.45)
    assert 0.1 < np.mean(darker) < 0.5


def test_hair_shows_a_picture_of_strands_and_all_else_none(draw):
    """Twice beside each other, rows along the strands."""
    steps = np.linspace(-1, 1, 9)
    points = np.stack([*np.meshgrid(steps, steps), np.zeros((9, 9))], -1).reshape(-1, 3)
    corners = np.arange(81).reshape(9, 9)
    a, b, c, d = (each.ravel() for each in (corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    strands = np.ones((256, 256), np.float32)
    strands[:128] = 0.5
    strands[:, :64] *= 0.5
    at = 1 + (points[:, :2] + 1) * [1.0, -0.5]
    light = draw(make_piece(points, faces, Region.HAIR, GREY, strands=at), strands=strands).colours.mean(2) / 0.5
    upper = np.array([0.5, 1, 1, 1, 0.5, 1, 1, 1])
    columns = 15 + 10 * np.arange(8)
    np.testing.assert_allclose(light[80, columns], upper, rtol=1e-4)
    np.testing.assert_allclose(light[20, columns], 0.5 * upper, rtol=1e-4)
    bare = draw(make_piece(points, faces, Region.SKIN, GREY), strands=strands).colours
    np.testing.assert_allclose(bare[15:85, 15:85], 0.5, rtol=1e-4)


def test_hair_has_no_seam_where_strands_come_round(draw):
    """A square from the last column of a shell, a little before three pictures, to its first."""
    points, faces = SQUARE
    waves = np.cos(2 * np.pi * np.arange(256) / 256)[None].repeat(256, 0)
    across = np.where(points[:, 0] < 0, 2.95, 0.0)
    piece = make_piece(points, faces, Region.HAIR, GREY, strands=np.stack([across, points[:, 1]], 1))
    light = draw(piece, strands=waves.astype(np.float32)).colours[15:85, 15:85].mean(2)
    assert light.min() > 0.5 * np.cos(2 * np.pi * 0.055)


def test_folds_change_the_light_of_the_skin_alone(ball, draw):
    """They are told by triangles of the skin, normals and light in the axes of the head."""
    vertices, faces = ball
    skin = make_piece(0.5 * vertices - [0.6, 0, 0], faces, Region.SKIN, GREY)
    pieces = join_pieces([skin, make_piece(0.5 * vertices + [0.6, 0, 0], faces, Region.CLOTH, GREY)])
    normals = np.concatenate([vertices, vertices])
    way = np.array([-0.8, -0.36, -0.48])
    sky = Sky(way[None], np.ones((1, 3)), np.full(1, 4.0), np.full(3, 0.2), np.full(3, 0.2))
    pose = replace(POSE, rotation=head_rotation(np.array([0.2, 0.7, 0.3])))
    asked = {}

    def brightness(triangles, weights, normals, light):
        asked.update(triangles=triangles, weights=weights, normals=normals, light=light)
        return np.full((len(triangles), 3), [0.5, 0.25, 1.0])

    creases = SimpleNamespace(ground=SimpleNamespace(faces=faces), brightness=brightness)
    smooth, folded = (draw(pieces, normals, pose, sky, creases=each).colours for each in (None, creases))
    region = draw(pieces, normals, pose, sky).region
    np.testing.assert_allclose(folded[region == Region.SKIN], smooth[region == Region.SKIN] * [0.5, 0.25, 1], rtol=1e-5)
    np.testing.assert_array_equal(folded[region == Region.CLOTH], smooth[region == Region.CLOTH])
    places = np.einsum("nk,nkc->nc", asked["weights"], vertices[faces[asked["triangles"]]])
    assert (places @ pose.rotation[2] < 0.3).all(), "no triangle is on the far side"
    np.testing.assert_allclose(asked["normals"], places / np.linalg.norm(places, axis=1, keepdims=True), atol=0.05)
    around = np.random.default_rng(0).normal(size=(4000, 3))
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    told = (harmonics(around) @ asked["light"])[:, 0]
    assert around[told.argmax()] @ (pose.rotation.T @ way) > 0.97
    assert told.mean() == pytest.approx(sky.radiance(DIRECTIONS)[:, 0].mean(), rel=0.1)


def test_strands_are_long_and_fine_and_their_picture_has_no_borders():
    strands = random_strands(np.random.default_rng(0))
    along, across = (np.abs(np.diff(strands, axis=axis)).mean() for axis in (0, 1))
    assert across > 5 * along
    for axis, usual in ((0, along), (1, across)):
        first, last = (np.take(strands, row, axis) for row in (0, -1))
        assert np.abs(first - last).mean() < 1.5 * usual
    assert strands.mean() == pytest.approx(1, abs=0.02) and strands.std() == pytest.approx(0.35, abs=0.05)
    assert strands.min() > 0


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.3, 0.9, 0.4), (-0.2, -0.6, 1.5)])
def test_light_comes_from_one_side_of_the_picture_however_a_head_is_turned(ball, head_template, angles):
    vertices, faces = ball
    transfer = (4 / len(DIRECTIONS) * np.maximum(vertices @ DIRECTIONS.T, 0)).astype(np.float32)
    piece = make_piece(vertices, faces, Region.SKIN, GREY)
    sitter = Sitter(head_template, piece, vertices, transfer, Eyes([], np.zeros(3), 0.5), np.zeros((0, 3)))
    left = Sky(np.array([[-1.0, 0, 0]]), np.ones((1, 3)), np.full(1, 4.0), np.full(3, 0.01), np.full(3, 0.01))
    pose = replace(POSE, rotation=head_rotation(np.array(angles)))
    light = draw_sitter(sitter, pose, SIZE, left, PLAIN, np.random.default_rng(0)).colours.mean(2)
    assert light[35:66, 14:30].mean() > 5 * light[35:66, 70:86].mean()
    assert light[14:30, 35:66].mean() == pytest.approx(light[70:86, 35:66].mean(), rel=0.3)


def head_pose(head, yaw):
    height = float(np.ptp(head.vertices[:, 1]))
    middle = (head.vertices.min(0) + head.vertices.max(0)) / 2
    return Pose(head_rotation(np.array([0, yaw, 0])), 90 / height, np.array([50.0, 50.0]), 0.0, middle, height)


@pytest.mark.parametrize(
    ("region", "covers"),
    [(Region.HAIR, True), (Region.BEARD, True), (Region.GLASSES, True), (Region.HAT, True), (Region.CLOTH, True)]
    + [(Region.SKIN, False), (Region.LIPS, False)],
)
def test_what_lies_on_the_skin_hides_landmarks_by_what_it_is(draw, head_template, region, covers):
    drawing = draw(
        make_piece(head_template.vertices, head_template.faces, region, GREY), pose=head_pose(head_template, 0)
    )
    assert drawing.visible[17:68].mean() == (0 if covers else 1)


@pytest.mark.parametrize("yaw", [0.7, -0.7])
def test_landmarks_of_the_jaw_are_on_the_outline_of_a_turned_head_and_seen(draw, head_template, yaw):
    piece = make_piece(head_template.vertices, head_template.faces, Region.SKIN, GREY)
    drawing = draw(piece, pose=head_pose(head_template, yaw))
    front = drawing.pose.rotation @ [0, 0, 1]
    far = range(3, 6) if drawing.points[0, 0] * front[0] > drawing.points[16, 0] * front[0] else range(11, 14)
    for number in far:
        x, y = drawing.points[number]
        across = np.flatnonzero(drawing.region[round(y)])
        edge = across.max() if front[0] > 0 else across.min()
        assert abs(x - edge) < 2.5
    assert drawing.visible[list(far)].all()
