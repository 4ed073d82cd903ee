from types import SimpleNamespace

import numpy as np
import pytest

from caricli.render.coat import Coat
from caricli.render.lights import KEY
from caricli.render.shade import Look, shade
from caricli.render.sky import DIRECTIONS, key_directions, mesh_sky, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import TO_PICTURE, turn_about_y
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Material, Pictures

SIZE = 64


def in_picture(vertices, scale=24.0, size=SIZE):
    return scale * vertices * [1, -1, -1] + [(size - 1) / 2, (size - 1) / 2, 0]


def test_alpha_is_coverage_with_soft_borders(sphere):
    picture = shade(in_picture(sphere[0]), sphere[1], SIZE, SIZE)
    assert picture.shape == (SIZE, SIZE, 4) and picture.dtype == np.uint8
    alpha = picture[..., 3] / 255
    assert alpha[0, 0] == 0 and alpha[SIZE // 2, SIZE // 2] == 1
    assert 0.02 < ((alpha > 0) & (alpha < 1)).mean() < 0.1
    assert abs(alpha.sum() / (np.pi * 24**2) - 1) < 0.01
    hard = rasterise(in_picture(sphere[0]), sphere[1], SIZE, SIZE).face >= 0
    assert (np.abs(alpha - hard) < 1).all()


def test_light_comes_from_the_upper_left_and_is_neither_burnt_nor_black(sphere):
    picture = shade(in_picture(sphere[0]), sphere[1], SIZE, SIZE)[..., :3].astype(float).mean(-1)
    c, d = SIZE // 2, 12
    assert picture[c - d, c - d] > picture[c, c] > picture[c + d, c + d] > 40
    assert picture.max() < 250


def test_colours_are_of_the_vertices_and_the_right_channel(sphere):
    vertices, faces = sphere
    colours = np.where(vertices[:, :1] > 0, [200.0, 30, 30], [30.0, 30, 200])
    picture = shade(in_picture(vertices), faces, SIZE, SIZE, Look(vertex_colours=colours)).astype(int)
    left, right = picture[SIZE // 2, SIZE // 4], picture[SIZE // 2, 3 * SIZE // 4]
    assert left[2] > 2 * left[0] and right[0] > 2 * right[2]
    plain = shade(in_picture(vertices), faces, SIZE, SIZE, Look(colour=(30, 200, 30))).astype(int)
    assert plain[SIZE // 2, SIZE // 2, 1] > 2 * plain[SIZE // 2, SIZE // 2, 0]


def test_what_is_seen_from_inside_is_dark_and_lets_the_outside_behind_it_through(sphere):
    vertices, faces = sphere
    turned = shade(in_picture(vertices), faces[(vertices[faces].mean(1)[:, 2] < -0.3)], SIZE, SIZE)
    centre = turned[SIZE // 2, SIZE // 2]
    assert centre[3] == 255 and centre[:3].max() < 60
    both = np.concatenate([in_picture(vertices), in_picture(vertices) - [0, 0, 100]])
    cap = faces[(vertices[faces].mean(1)[:, 2] < -0.3)] + len(vertices)
    through = shade(both, np.concatenate([faces, cap]), SIZE, SIZE)[SIZE // 2, SIZE // 2]
    assert through[:3].min() > 80


@pytest.mark.filterwarnings("error")  # a colour that is not a number warns when it becomes a byte
def test_folds_are_darker_than_the_open_skin():
    x, y = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-1, 1, 81))
    pit = np.stack([x, y, -1.2 * np.exp(-30 * (x**2 + y**2))], -1).reshape(-1, 3)
    k = np.arange(81 * 81).reshape(81, 81)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    picture = shade(in_picture(pit, 30.0), faces, SIZE, SIZE)[..., :3].astype(float).mean(-1)
    assert picture[SIZE // 2, SIZE // 2] < 0.5 * picture[SIZE // 2, 6]


def test_an_eyeball_looks_along_its_gaze_and_hides_behind_the_mesh(sphere):
    vertices, faces = sphere
    far = in_picture(vertices * 0.1) + [0, 0, 90]
    middle = [(SIZE - 1) / 2, (SIZE - 1) / 2, 0.0]
    ball = shade(far, faces, SIZE, SIZE, Look(eyeballs=[(middle, 20.0)])).astype(int)
    assert ball[SIZE // 2, SIZE // 2, :3].max() < 40 and ball[SIZE // 2, SIZE // 2, 3] == 255  # the pupil
    assert ball[SIZE // 2, SIZE // 2 + 12, :3].min() > 90  # the white
    turned = shade(far, faces, SIZE, SIZE, Look(eyeballs=[(middle, 20.0)], gaze=(0.6, 0, -0.8))).astype(int)
    assert turned[SIZE // 2, SIZE // 2 + 12, :3].max() < 70
    near = in_picture(vertices) - [0, 0, 90]
    plain = shade(near, faces, SIZE, SIZE)
    assert (shade(near, faces, SIZE, SIZE, Look(eyeballs=[(middle, 20.0)])) == plain).all()


def test_same_input_same_bytes_and_inputs_are_not_changed(lopsided):
    vertices, faces = in_picture(lopsided[0], 15.0), lopsided[1]
    before = vertices.copy()
    assert shade(vertices, faces, SIZE, SIZE).tobytes() == shade(vertices, faces, SIZE, SIZE).tobytes()
    assert (vertices == before).all()


def test_nothing_to_draw_is_transparent():
    assert (shade(np.zeros((3, 3)), np.zeros((0, 3), int), 8, 5) == np.zeros((5, 8, 4))).all()


def grey(picture):
    return picture[..., :3].astype(float).mean(-1)


def test_a_convex_body_has_no_shadow_of_its_own(sphere):
    points, faces = in_picture(sphere[0]), sphere[1]
    free = np.ones((len(points), len(DIRECTIONS)), np.float32)
    own, unhindered = (shade(points, faces, SIZE, SIZE, Look(visibility=seen)) for seen in (None, free))
    assert np.abs(own.astype(int) - unhindered).max() <= 3


def test_what_stands_in_the_lights_way_shades_the_ground(sphere):
    vertices, faces = sphere

    steps = np.linspace(0, 1, 33)
    grid = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    ground = np.column_stack([grid * SIZE, np.full(len(grid), 30.0)])
    k = np.arange(33 * 33).reshape(33, 33)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    floor = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])
    ball = 8 * vertices * [1, -1, -1] + [20, 20, 10]
    bare = grey(shade(ground, floor, SIZE, SIZE))
    both = grey(shade(np.concatenate([ground, ball]), np.concatenate([floor, faces + len(ground)]), SIZE, SIZE))
    # The light comes from the upper left: the shadow lies to the lower right, and softly.
    assert both[44, 44] < bare[44, 44] - 15
    assert abs(both[8, 50] - bare[8, 50]) < 8
    assert (np.abs(np.diff(both[44, 34:])) < 25).all()


def test_red_light_reaches_further_round_skin_than_round_hair(sphere):
    points, faces = in_picture(sphere[0]), sphere[1]
    warmth = {}
    for material in (Material.SKIN, Material.BUST, Material.TONGUE, Material.HAIR):
        coat = Coat(np.zeros((1, 2)), np.zeros_like(faces), np.full(len(faces), material), Pictures())
        drawn = shade(points, faces, SIZE, SIZE, Look(colour=(150, 150, 150), coat=coat)).astype(float)
        warmth[material] = drawn[40, 40, 0] - drawn[40, 40, 1] - (drawn[25, 25, 0] - drawn[25, 25, 1])
    assert min(warmth[soft] for soft in (Material.SKIN, Material.BUST, Material.TONGUE)) > warmth[Material.HAIR] + 1


def test_wet_materials_mirror_the_light_and_dry_ones_do_not(sphere):
    points, faces = in_picture(sphere[0]), sphere[1]
    brightest = {}
    for material in (Material.SKIN, Material.TEETH, Material.TONGUE, Material.HAIR):
        coat = Coat(np.zeros((1, 2)), np.zeros_like(faces), np.full(len(faces), material), Pictures())
        brightest[material] = grey(shade(points, faces, SIZE, SIZE, Look(colour=(90, 90, 90), coat=coat))).max()
    assert min(brightest[Material.TEETH], brightest[Material.TONGUE]) > 1.2 * max(
        brightest[Material.SKIN], brightest[Material.HAIR]
    )


def _down_from_the_top(vertices):
    x, y, z = vertices.T
    turn, share = np.arctan2(x, -z), 0.5 * np.arccos(np.clip(y, -1, 1)) / np.pi
    return 0.5 + share[:, None] * np.stack([np.sin(turn), np.cos(turn)], 1)


def test_light_on_hair_runs_across_its_strands_and_is_uneven_from_one_to_the_next(sphere):
    """Strands run down from the top, the middle of the picture of the hair."""
    points, faces = in_picture(sphere[0]), sphere[1]
    strands = _down_from_the_top(sphere[0])
    drawn = {}
    for name, uvs in (("strands", strands), ("plain", np.zeros_like(strands))):
        coat = Coat(uvs, faces, np.full(len(faces), Material.HAIR), Pictures())
        drawn[name] = grey(shade(points, faces, SIZE, SIZE, Look(colour=(60, 50, 40), coat=coat)))
    facing = np.s_[16:48, 16:48]
    uneven = {name: np.abs(np.diff(grey_levels[facing], axis=1)).mean() for name, grey_levels in drawn.items()}
    assert uneven["strands"] > 2 * uneven["plain"]
    across = drawn["strands"][facing].mean(1)
    assert across.argmax() not in (0, len(across) - 1) and across.max() > across[[0, -1]].max() + 3


def test_an_eye_has_a_highlight_towards_the_light_wherever_it_looks(sphere):
    far = in_picture(sphere[0] * 0.1) + [0, 0, 90]
    middle = [(SIZE - 1) / 2, (SIZE - 1) / 2, 0.0]
    for gaze in ((0, 0, -1), (0.3, 0.1, -0.95), (-0.3, 0, -0.95)):
        ball = grey(shade(far, sphere[1], SIZE, SIZE, Look(eyeballs=[(middle, 20.0)], gaze=gaze)))
        bright = np.argwhere(ball > 235)
        assert 4 < len(bright) < 120
        assert (bright.mean(0) < SIZE / 2 - 2).all()


def test_a_wet_mouth_and_an_eye_are_lit_where_skin_in_their_place_is_dark():
    """At the bottom of a pit."""
    x, y = np.meshgrid(np.linspace(-1, 1, 61), np.linspace(-1, 1, 61))
    pit = np.stack([x, y, -1.5 * np.exp(-20 * (x**2 + y**2))], -1).reshape(-1, 3)
    k = np.arange(61 * 61).reshape(61, 61)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    deep = {}
    for material in (Material.SKIN, Material.TEETH, Material.EYE):
        coat = Coat(np.zeros((1, 2)), np.zeros_like(faces), np.full(len(faces), material), Pictures())
        deep[material] = grey(shade(in_picture(pit, 30.0), faces, SIZE, SIZE, Look(coat=coat)))[32, 32]
    assert min(deep[Material.TEETH], deep[Material.EYE]) > 1.3 * deep[Material.SKIN]


def test_the_border_of_a_dark_body_is_no_bright_line(sphere):
    """Before another one it is a pixel wide, and dotted."""
    points, faces = in_picture(sphere[0]), sphere[1]
    drawn = shade(points, faces, SIZE, SIZE, Look(colour=(25, 25, 25))).astype(float)
    solid = drawn[..., 3] == 255
    assert drawn[solid][:, :3].mean(1).max() < 105, drawn[solid][:, :3].mean(1).max()


def test_an_eye_of_the_mesh_is_drawn_as_one_beside_it(sphere):
    vertices, faces = sphere
    away = np.arccos(np.clip(vertices[:, 2], -1, 1))
    around = np.arctan2(vertices[:, 1], vertices[:, 0])
    uvs = 0.5 + np.column_stack([away * np.cos(around), away * np.sin(around)]) / (2 * np.pi)
    iris = np.hypot(*(np.mgrid[:128, :128] - 63.5)) < 10
    picture = np.where(iris[..., None], (40, 60, 110), (50, 40, 40)).astype(np.uint8)
    for turn in (-25, 0, 25):
        rotation = TO_PICTURE @ turn_about_y(turn)
        points = 20 * vertices @ rotation.T + [31.5, 31.5, 0]
        coat = Coat(uvs, faces, np.full(len(faces), Material.EYE), Pictures(eyes=picture))
        of_mesh = shade(points, faces, SIZE, SIZE, Look(coat=coat)).astype(int)
        look = Look(coat=coat, eyeballs=[((31.5, 31.5, 0.0), 20.0)], gaze=rotation[:, 2])
        beside = shade(0.1 * points + [28, 28, 90], faces, SIZE, SIZE, look).astype(int)
        bright = [np.argwhere(grey(each) > 0.93 * grey(each).max()).mean(0) for each in (of_mesh, beside)]
        assert np.abs(bright[0] - bright[1]).max() < 1.5
        blue = [np.argwhere(each[..., 2] > each[..., 0] + 25).mean(0) for each in (of_mesh, beside)]
        assert np.abs(blue[0] - blue[1]).max() < 2


@pytest.fixture(scope="module")
def turned(lopsided):
    """A lopsided head turned aside and tilted, in pixels; its faces; and how it was turned."""
    rotation = TO_PICTURE @ np.roll(turn_about_y(25), (1, 1), (0, 1)) @ turn_about_y(60)
    return 18 * lopsided[0] @ rotation.T + [31.5, 31.5, 0], lopsided[1], rotation


def test_what_a_mesh_saw_before_it_was_turned_lights_it_as_what_it_sees_now(lopsided, turned):
    points, faces, rotation = turned
    normals = smooth_normals(*lopsided)
    sky = mesh_sky(*lopsided)
    key = sky_visibility(*lopsided, normals, None, key_directions(KEY) @ rotation)
    drawn = [
        shade(points, faces, SIZE, SIZE, look).astype(int)
        for look in (
            None,
            Look(visibility=sky, rotation=rotation),
            Look(visibility=sky, key=key, rotation=rotation),
            Look(visibility=0 * sky, key=0 * key, rotation=rotation, hidden=np.ones(len(sky), bool)),
        )
    ]
    for other in drawn[1:]:
        assert np.abs(drawn[0] - other).max() <= 3 and np.abs(drawn[0] - other).mean() < 0.02
    dark = [
        shade(points, faces, SIZE, SIZE, look).astype(int)
        for look in (
            Look(visibility=0 * sky, rotation=rotation),
            Look(visibility=sky, key=0 * key, rotation=rotation),
        )
    ]
    assert all(grey(drawn[0]).mean() > grey(other).mean() + 2 for other in dark)


def test_hair_is_shaded_as_it_is_combed_and_shines_as_much_as_it_says(sphere):
    points, faces = in_picture(sphere[0]), sphere[1]
    coat = Coat(_down_from_the_top(sphere[0]), faces, np.full(len(faces), Material.HAIR), Pictures())

    def combed(shine, even):
        normals = (lambda own: np.tile([0, 0, -1.0], (len(own), 1))) if even else (lambda own: own)
        return SimpleNamespace(normals=normals, shine=np.full(len(points), shine))

    even, round_ = (
        grey(shade(points, faces, SIZE, SIZE, Look(hair=combed(1.0, way), visibility=np.ones((len(points), 48)))))
        for way in (True, False)
    )
    middle = np.s_[18:46, 18:46]
    assert even[middle].std() < 0.3 * round_[middle].std()
    shining, matt = (
        grey(shade(points, faces, SIZE, SIZE, Look(colour=(60, 50, 40), coat=coat, hair=combed(shine, False))))
        for shine in (1.0, 0.0)
    )
    assert shining.max() > matt.max() + 5


def test_a_coarse_mesh_is_rounded_off():
    """An octahedron whose corners are on a circle: a square where it is flat."""
    vertices = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    alpha = shade(in_picture(vertices), faces, SIZE, SIZE)[..., 3] / 255
    assert alpha.sum() > 1.04 * 2 * 24**2


def test_eyeballs_keep_what_is_fine_in_their_picture(sphere):
    """Stripes of three pixels around an eye, of one whose mesh has none of its own."""
    picture = np.zeros((256, 256, 3), np.uint8)
    picture[:, np.arange(256) // 6 % 2 == 0] = 255
    faces = sphere[1]
    coat = Coat(np.zeros((1, 2)), np.zeros_like(faces), np.zeros(len(faces), int), Pictures(eyes=picture))
    far = in_picture(sphere[0] * 0.1) + [0, 0, 90]
    middle = [(SIZE - 1) / 2, (SIZE - 1) / 2, 0.0]
    eye = grey(shade(far, faces, SIZE, SIZE, Look(coat=coat, eyeballs=[(middle, 24.0)])))
    assert np.abs(np.diff(eye[36:52, 20:44], axis=1)).mean() > 15


def test_light_gets_no_colour_under_a_grey_skin(sphere):
    """The same plain tongue, beside skin of one picture or another."""
    points, faces = in_picture(sphere[0]), sphere[1]
    warmth = []
    for colour in ((206, 160, 136), (160, 160, 160)):
        worn = Pictures(np.full((4, 4, 3), colour, np.uint8))
        coat = Coat(np.zeros((1, 2)), np.zeros_like(faces), np.full(len(faces), Material.TONGUE), worn)
        drawn = shade(points, faces, SIZE, SIZE, Look(colour=(150, 150, 150), coat=coat)).astype(float)
        warmth.append(drawn[40, 40, 0] - drawn[40, 40, 1] - (drawn[25, 25, 0] - drawn[25, 25, 1]))
    assert warmth[0] > warmth[1] + 1, warmth
