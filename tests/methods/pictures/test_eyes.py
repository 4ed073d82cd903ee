from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.pictures.eyes import Canvas, Eyes, draw_eyes
from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.pose import Pose
from caricli.structures.parsing import Region

SIZE = 100
RADIUS = 0.02
"""Metres; 20 pixels in POSE."""
POSE = Pose(head_rotation(np.zeros(3)), 1000.0, np.array([50.0, 46.0]), 0.0, np.zeros(3), 0.25)
EVEN = Sky(np.array([[-0.8, -0.6, 0.0]]), np.zeros((1, 3)), np.ones(1), np.ones(3), np.ones(3))
GREEN = np.array([0.02, 0.5, 0.02])


def drawn(pose=POSE, seed=0, centres=((0.0, 0.0, 0.0),), depth=np.inf, sky=EVEN, iris=GREEN):
    canvas = Canvas(np.zeros((SIZE, SIZE, 3)), np.zeros((SIZE, SIZE), np.uint8), np.full((SIZE, SIZE), depth))
    eyes = Eyes([(np.array(centre), RADIUS) for centre in centres], iris, 0.5)
    draw_eyes(canvas, eyes, pose, sky, np.random.default_rng(seed))
    return canvas


def middle_of(mask):
    """Column and row."""
    return np.argwhere(mask).mean(0)[::-1]


def pupil_of(canvas):
    return middle_of((canvas.region == Region.EYES) & (canvas.colours.max(2) < 0.02))


@pytest.mark.parametrize("perspective", [0.0, 1.0])
def test_an_eyeball_is_a_disc_where_the_pose_has_it(perspective):
    """All but what its lids would hide from before it."""
    centre = np.array([0.01, 0.008, 0.05])
    pose = replace(POSE, perspective=perspective)
    canvas = drawn(pose, centres=[centre])
    place = pose.place(centre[None])[0]
    rows, columns = np.mgrid[:SIZE, :SIZE]
    away = np.hypot(columns - place[0], rows - place[1]) / (RADIUS * pose.size_at(np.array(-0.05)))
    eyes = canvas.region == Region.EYES
    assert eyes[away < 0.93].all() and not eyes[away > 0.97].any()
    assert (canvas.colours[eyes] > 0).all() and not canvas.colours[~eyes].any()


def test_what_is_before_an_eyeball_hides_it():
    """Flat things at three depths, pixels: before the ball, half a radius before its middle, and behind it."""
    rows, columns = np.mgrid[:SIZE, :SIZE]
    away = np.hypot(columns - 50, rows - 46) / 20
    before, among, behind = (drawn(depth=depth).region == Region.EYES for depth in (-25.0, -10.0, 5.0))
    assert not before.any()
    assert among[away < 0.83].all() and not among[away > 0.9].any()
    assert behind[away < 0.93].all()


@pytest.mark.parametrize("yaw", [70.0, -70.0])
def test_of_an_eyeball_only_the_front_shows(yaw):
    pose = replace(POSE, rotation=head_rotation(np.radians([0, yaw, 0])))
    front = pose.rotation @ [0, 0, 1]
    shown = np.argwhere(drawn(pose).region == Region.EYES)[:, ::-1] - [50, 46]
    assert np.sign(shown[:, 0].mean()) == np.sign(front[0])
    # Its rim on the far side is 0.3 radii before the middle, as seen by the face.
    assert (shown @ front[:2]).min() / 20 > 0.3 * abs(front[0]) - np.sqrt(1 - 0.3**2) * abs(front[2]) - 0.06


def test_an_iris_lies_around_its_pupil_in_the_white():
    for seed in range(5):
        canvas = drawn(seed=seed)
        away = np.linalg.norm(np.mgrid[:SIZE, :SIZE][::-1].transpose(1, 2, 0) - pupil_of(canvas), axis=2)
        eye = (canvas.region == Region.EYES) & (canvas.colours.max(2) < 0.94)
        green = eye & (canvas.colours[..., 1] > 5 * canvas.colours[..., 0])
        black = eye & (canvas.colours.max(2) < 0.02)
        white = eye & ~green & ~black
        assert min(green.sum(), black.sum(), white.sum()) > 30
        assert away[black].max() < away[green].mean() < away[white].min() + 3
        assert black.sum() < green.sum() < white.sum()


@pytest.mark.parametrize("yaw", [0.0, 40.0, -40.0])
def test_both_eyes_look_the_same_way_about_where_the_face_looks(yaw):
    pose = replace(POSE, rotation=head_rotation(np.radians([0, yaw, 0])))
    left = np.array([-0.02, 0, 0])
    ways = []
    for seed in range(40):
        at = [pupil_of(drawn(pose, seed, [shift])) - pose.place(shift[None])[0, :2] for shift in (left, -left)]
        assert np.abs(at[0] - at[1]).max() < 1
        ways.append(at[0] / 20)
    front = (pose.rotation @ [0, 0, 1])[:2]
    assert np.abs(np.mean(ways, axis=0) - front).max() < 0.12
    assert np.std(ways, axis=0).min() > 0.05


def test_light_on_an_eyeball_is_that_of_the_sky_on_its_side():
    lamp = Sky(np.array([[-1.0, 0, 0]]), np.ones((1, 3)), np.full(1, 4.0), np.full(3, 0.01), np.full(3, 0.01))
    side = drawn(sky=lamp).colours.mean(2)
    assert side[40:52, 32:42].mean() > 2 * side[40:52, 58:68].mean()
    # An even sky of radiance one gives all of it; the lid takes some.
    even = drawn(iris=np.full(3, 0.5)).colours[44:49, 46:55]
    assert 0.4 < np.median(even[even > 0.02]) < 0.52


def test_the_upper_lid_shades_what_is_below_it():
    light = np.mean([drawn(seed=seed, iris=np.full(3, 0.7)).colours.mean(2) for seed in range(20)], axis=0)
    assert light[30:36, 46:55].mean() < 0.8 * light[57:63, 46:55].mean()
    assert light[40:53, 33:37].mean() == pytest.approx(light[40:53, 64:68].mean(), rel=0.25)


@pytest.mark.parametrize("way", [[-0.8, -0.6, 0.0], [0.8, -0.6, 0.0], [0.0, 0.8, -0.6]])
def test_a_lamp_is_mirrored_half_way_to_it(way):
    sky = replace(EVEN, ways=np.array([way]))
    glint = middle_of((drawn(sky=sky).colours == 0.95).all(2))
    np.testing.assert_allclose((glint - [50, 46]) / 20, sky.half[:2], atol=0.06)


def test_an_eyeball_at_the_border_is_cut_off():
    for corner in ([-48, -44], [48, 44]):
        shift = np.array([*(corner * np.array([1, -1]) / 1000), 0.0])
        rows, columns = np.nonzero(drawn(centres=[shift]).region)
        assert 150 < len(rows) < 700
        assert np.abs(np.stack([columns, rows], 1) - [50, 46] - corner).max() < 20
