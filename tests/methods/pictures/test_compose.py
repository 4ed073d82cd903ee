from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.methods.pictures import compose
from caricli.methods.pictures.compose import Easel
from caricli.methods.pictures.draw_sitter import Drawing
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.settings import PoseSettings, SceneSettings
from caricli.render.pixels.srgb import to_srgb
from caricli.render.sky import DIRECTIONS
from caricli.structures.parsing import Region

SIZE = 32
GROUND = 0.25
COLOURS = np.array([[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9], [0.9, 0.9, 0.1]])
SHADES = [0.1, 1, 1, 2, 2, 2, 2]
SHOWN = np.repeat([Region.SKIN, Region.HAIR], [3, 4])
SITTERS: list[Any] = [
    SimpleNamespace(skin=None, pieces=SimpleNamespace(colours=np.outer(SHADES, colour), region=SHOWN))
    for colour in COLOURS
]
"""Squares in the middle of the picture, as large as their pose says, of a skin with a dark spot, and bright hair."""
ALONE = SceneSettings(none=0, several=0, held=0)
TOGETHER = SceneSettings(none=0, several=1, held=0)


@pytest.fixture
def asked(monkeypatch):
    """What was asked of poses: shares and settings. Pictures are of one medium that leaves them as they are."""
    poses = []

    def posed(head, size, filled, generator, settings):
        poses.append((filled, settings))
        return Pose(np.eye(3), filled * size, np.full(2, (size - 1) / 2), 0.0, np.zeros(3), 1.0)

    def drawn(sitter, pose, size, sky, strands, generator):
        away = np.abs(np.mgrid[:size, :size] - (size - 1) / 2).max(0)
        inside = away < pose.scale / 2
        colours = np.where(inside[..., None], sitter.pieces.colours[1], 7.0).astype(np.float32)
        # In the middle, at the left of the square, and in a corner of the picture.
        points = np.array([[size / 2, size / 2], [size / 2 - pose.scale / 2 + 1, size / 2], [1.0, 1.0]])
        return Drawing(colours, np.where(inside, Region.SKIN, 0).astype(np.uint8), points, np.ones(3, bool), pose)

    monkeypatch.setattr(compose, "random_pose", posed)
    monkeypatch.setattr(compose, "draw_sitter", drawn)
    monkeypatch.setattr(compose, "random_strands", lambda generator: None)
    monkeypatch.setattr(compose, "random_background", lambda size, generator: np.full((size, size, 3), GROUND))
    monkeypatch.setattr(compose, "MEDIA", {"plain": (lambda image, region, generator: image, 1.0)})
    monkeypatch.setattr(compose, "_exposed", lambda image, region, generator: image)
    return poses


def people(easel, count=4, first=1, times=200):
    """Who was drawn, how large, and whether from behind, each time."""
    generator = np.random.default_rng(0)
    drawn = [easel._people(SITTERS[:count], first, None, generator) for _ in range(times)]
    return [([number for number, _, _ in each], [drawing.pose.scale for _, drawing, _ in each], each) for each in drawn]


def test_one_alone_is_the_one_whose_turn_it_is(asked):
    easel = Easel(SIZE, ALONE)
    assert all(numbers == [1] and not each[0][2] for numbers, _, each in people(easel, times=20))
    assert all(settings is easel.poses for _, settings in asked)


def test_several_are_different_people_the_smallest_first_further_apart_and_smaller(asked):
    easel = Easel(SIZE, TOGETHER)
    drawn = people(easel)
    assert {len(numbers) for numbers, _, _ in drawn} == {2, 3, 4}
    assert all(len({*numbers}) == len(numbers) and scales == sorted(scales) for numbers, scales, _ in drawn)
    assert {number for numbers, _, _ in drawn for number in numbers} == {0, 1, 2, 3}
    poses = easel.poses
    assert all(settings == replace(poses, aside=poses.apart) for _, settings in asked)
    shares = np.array([filled for filled, _ in asked])
    assert 0.3 * poses.filled[0] < shares.min() < 0.2 and 0.45 < shares.max() < 0.7 * poses.filled[1]
    assert {len(numbers) for numbers, _, _ in people(easel, count=2, times=30)} == {2}


def test_how_often_there_is_no_face_and_how_often_one_turned_away(asked):
    easel = Easel(SIZE, SceneSettings(none=0.4, several=0.3, away=0.7))
    drawn = people(easel, times=500)
    away = [each for numbers, _, each in drawn if numbers and each[0][2]]
    empty = [numbers for numbers, _, _ in drawn if not numbers]
    together = [numbers for numbers, _, _ in drawn if len(numbers) > 1]
    shares = np.array([len(away), len(empty), len(together)]) / 500
    np.testing.assert_allclose(shares, [0.28, 0.12, 0.3], atol=0.06)
    assert all(len(each) == 1 for each in away)
    turned = [settings for _, settings in asked if settings.around]
    assert len(turned) == len(away)
    assert all(each == replace(easel.poses, around=180, farthest=easel.poses.behind) for each in turned)


@pytest.mark.parametrize(
    ("chances", "limits"),
    [((0, 0), "filled"), ((1, 0), "close_filled"), ((0, 1), "small_filled")],
)
def test_faces_fill_as_much_as_their_kind(chances, limits):
    poses = PoseSettings(close=chances[0], small=chances[1])
    generator = np.random.default_rng(0)
    shares = np.array([Easel(SIZE, ALONE, poses)._filled(1, generator) for _ in range(300)])
    low, high = getattr(poses, limits)
    assert low <= shares.min() < low + 0.05 * (high - low) and high - 0.05 * (high - low) < shares.max() <= high
    # As many small faces are half as large as are twice as large.
    middle = np.sqrt(low * high) if limits == "small_filled" else (low + high) / 2
    assert np.median(shares) == pytest.approx(middle, rel=0.07)


def test_faces_that_are_not_small_may_be_close():
    poses = PoseSettings(close=0.4, small=0.6)
    generator = np.random.default_rng(0)
    shares = np.array([Easel(SIZE, ALONE, poses)._filled(1, generator) for _ in range(300)])
    assert ((shares <= poses.small_filled[1]) | (shares >= poses.close_filled[0])).all()
    assert (shares >= poses.close_filled[0]).mean() == pytest.approx(0.4, abs=0.08)


def test_whoever_is_larger_stands_before_the_others_on_what_is_behind_all(asked):
    easel = Easel(SIZE, TOGETHER)
    generator = np.random.default_rng(0)
    for _ in range(10):
        picture = easel.compose(SITTERS, 0, generator)
        faces = picture.faces
        assert [face.scale for face in faces] == sorted((face.scale for face in faces), reverse=True)
        middle = picture.image[SIZE // 2, SIZE // 2]
        np.testing.assert_allclose(middle, 255 * to_srgb(COLOURS[faces[0].sitter]), atol=1)
        np.testing.assert_allclose(picture.image[0, 0], 255 * to_srgb(np.array(GROUND)), atol=1)
        assert (picture.region > 0).sum() == pytest.approx(faces[0].scale ** 2, rel=0.3)
        # Their middles are behind the largest; what is beside all is seen.
        assert [face.visible[0] for face in faces] == [True] + [False] * (len(faces) - 1)
        assert faces[0].visible.all() and all(face.visible[2] for face in faces)


def test_what_is_held_is_before_the_nearest_face_in_its_light_and_hides_it(asked, monkeypatch):
    told = []

    def hold(image, region, points, skin, generator):
        told.append((points, skin))
        region[:, : len(region) // 2 - 1] = Region.OTHER

    monkeypatch.setattr(compose, "hold_before", hold)
    sky = compose.random_sky(np.random.default_rng(9))
    monkeypatch.setattr(compose, "random_sky", lambda generator: sky)
    generator = np.random.default_rng(0)
    for scene in (replace(ALONE, held=1), replace(TOGETHER, held=1)):
        picture = Easel(SIZE, scene, PoseSettings(small=0)).compose(SITTERS, 2, generator)
        points, skin = told[-1]
        nearest = picture.faces[0]
        np.testing.assert_allclose((points + 0.5) * SIZE / 48 - 0.5, nearest.points)
        np.testing.assert_allclose(skin, COLOURS[nearest.sitter] * sky.above)
        assert nearest.visible.tolist() == [True, False, False]
        np.testing.assert_array_equal(nearest.light, sky.harmonics(DIRECTIONS))
    Easel(SIZE, SceneSettings(none=1, away=1, held=1)).compose(SITTERS, 0, generator)
    assert len(told) == 2, "nothing is held before the back of a head"


def test_who_has_no_bare_skin_has_hands_nevertheless():
    pieces: Any = SimpleNamespace(colours=COLOURS[[0, 1, 1]], region=np.full(3, Region.HAT))
    np.testing.assert_array_equal(compose._skin_tone(pieces), COLOURS[1])


def test_media_get_the_picture_in_srgb_and_its_labels_of_the_size_that_was_asked_for(asked, monkeypatch):
    given = []

    def medium(image, region, generator):
        given.append((image, region))
        return image

    monkeypatch.setattr(compose, "MEDIA", {"plain": (medium, 1.0)})
    region = np.zeros((48, 48), np.uint8)
    region[:, 17:] = Region.HAT
    image = np.full((48, 48, 3), 0.2)
    finished, labels = Easel(SIZE, ALONE)._finish(image, region, "plain", np.random.default_rng(0))
    assert finished.shape == (SIZE, SIZE, 3) and set(np.unique(labels)) == {0, Region.HAT}
    assert (finished == np.round(255 * to_srgb(np.array(0.2)))).all()
    np.testing.assert_allclose(given[0][0], to_srgb(np.array(0.2)), rtol=1e-6)
    assert given[0][1] is labels


def test_media_are_as_frequent_as_they_say(asked, monkeypatch):
    still = compose.MEDIA["plain"][0]
    monkeypatch.setattr(compose, "MEDIA", {"often": (still, 0.9), "seldom": (still, 0.1)})
    generator = np.random.default_rng(0)
    media = [Easel(8, ALONE).compose(SITTERS, 0, generator).medium for _ in range(200)]
    assert media.count("often") / 200 == pytest.approx(0.9, abs=0.06)


def test_pictures_are_exposed_for_the_skin_however_bright_they_are():
    region = np.zeros((40, 40), np.uint8)
    region[10:30, 10:30] = Region.SKIN
    image = np.where(region[..., None] > 0, [0.4, 0.3, 0.2], 0.05)
    image[10:14, 10:30] *= 0.1  # a shadow
    ratios = []
    for seed in range(200):
        exposed, brighter, before = (
            compose._exposed(each, region, np.random.default_rng(seed))
            for each in (image, 1.5 * image, np.where(region[..., None] > 0, image, 0.9))
        )
        np.testing.assert_allclose(exposed / exposed[0, 0], image / image[0, 0])
        np.testing.assert_allclose(exposed[20, 20], before[20, 20])
        assert exposed[20, 20, 0] == pytest.approx(brighter[20, 20, 0]) or exposed[20, 20, 0] < 0.3 * 0.6 + 1e-9
        ratios.append(exposed[20, 20, 0])
    assert 0.1 < min(ratios) and max(ratios) < 1.3 and np.median(ratios) == pytest.approx(0.65, abs=0.07)


def test_regions_lie_where_the_picture_shows_them(asked):
    """Of a picture that is drawn larger: the middle of a square, whose colour is the only one of its kind."""
    easel = Easel(SIZE, replace(ALONE, drawn=1.5))
    for number in range(4):
        drawn = easel.compose(SITTERS, number, np.random.default_rng(number))
        shown = np.abs(drawn.image.astype(float) - drawn.image[0, 0]).sum(2)
        weights = shown / shown.sum()
        places = np.indices(shown.shape)
        middles = [(places * part).sum((1, 2)) / part.sum() for part in (weights, drawn.region == Region.SKIN)]
        np.testing.assert_allclose(middles[1], middles[0], atol=0.17)
