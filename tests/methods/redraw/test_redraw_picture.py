from dataclasses import replace

import cv2
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.redraw.original import Original
from caricli.methods.redraw.redraw_picture import redraw_layer, redraw_picture
from caricli.methods.rig.add_parts import choose_parts
from caricli.structures import Camera, Depiction, HeadChoice, Material, Pictures
from caricli.structures.landmarks import EYE_LEFT
from caricli.structures.materials import FINISHES
from caricli.structures.parsing import Region
from caricli.structures.texture_change import TextureChange
from tests.methods.redraw.conftest import CAMERA, SIDE, WALL

OPEN = {"jawOpen": 0.8}
ASIDE = {"jawOpen": 1.0, "jawLeft": 1.0}


def error(image, truth, where):
    return np.abs(image.astype(float) - truth)[where].mean()


def test_a_head_that_keeps_still_leaves_the_picture_as_it_is(stage):
    original = stage.original(stage.shape())
    again = redraw_picture(original, stage.rig.neutral)
    np.testing.assert_array_equal(again, original.picture)
    assert again is not original.picture


@pytest.mark.parametrize("weights", [OPEN, {"mouthSmileLeft": 1, "browInnerUp": 1}, {"eyeBlinkLeft": 1}])
def test_it_comes_near_a_picture_of_the_expression(stage, weights):
    original = stage.original(stage.shape())
    truth = stage.picture(stage.shape(**weights))
    again = redraw_picture(original, stage.shape(**weights))
    moved = (truth != original.picture).any(2) & ~stage.mouth(stage.shape(**weights))
    assert error(again, truth, moved) < 0.5 * error(original.picture, truth, moved)
    changed = (again != original.picture).any(2)
    rows = np.flatnonzero(moved.any(1))
    # Nothing changes far from what has moved.
    assert not changed[: max(rows[0] - 8, 0)].any() and not changed[rows[-1] + 8 :].any()


def test_what_the_chin_uncovers_is_filled(stage):
    original = stage.original(stage.shape(**ASIDE))
    truth = stage.picture(stage.rig.neutral)
    bare = (truth == WALL).all(2) & (original.picture != WALL).any(2)
    assert bare.sum() > 20
    again = redraw_picture(original, stage.rig.neutral)
    assert error(again, truth, bare) < 0.4 * error(original.picture, truth, bare)


def cut_out(stage, vertices):
    """An Original of a shape whose wall is transparent, in a colour that nothing shows."""
    mask = stage.regions(vertices) == Region.SKIN
    head = stage.picture(vertices)
    layer = np.dstack([np.where(mask[..., None], head, [48, 32, 33]), np.where(mask, 255, 0)]).astype(np.uint8)
    return stage.original(vertices, picture=np.where(mask[..., None], head, 255).astype(np.uint8), layer=layer)


def on_paper(layer):
    alpha = layer[..., 3:] / 255
    return alpha * layer[..., :3] + (1 - alpha) * 255


@pytest.mark.parametrize(("before", "after"), [({}, ASIDE), (ASIDE, {})])
def test_what_is_transparent_stays_so_where_the_head_does_not_come(stage, before, after):
    original = cut_out(stage, stage.shape(**before))
    again = redraw_layer(original, stage.shape(**after))
    covered = stage.regions(stage.shape(**after)) == Region.SKIN
    mixed = cv2.morphologyEx(covered.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3))) > 0
    alpha = again[..., 3]
    assert alpha[covered & ~mixed].mean() > 254 and alpha[~covered & ~mixed].mean() < 1
    uncovered = (original.layer[..., 3] > 0) & ~covered & ~mixed
    newly = (original.layer[..., 3] == 0) & covered & ~mixed
    assert uncovered.sum() + newly.sum() > 20
    assert not newly.any() or alpha[newly].mean() > 250
    assert not uncovered.any() or alpha[uncovered].mean() < 0.4 * 255
    assert np.abs(on_paper(again) - redraw_picture(original, stage.shape(**after))).max() < 2
    clear = (alpha == 0) & (original.layer[..., 3] == 0)
    np.testing.assert_array_equal(again[clear], original.layer[clear])


def test_a_layer_of_a_head_that_keeps_still_stays_as_it_is(stage):
    original = cut_out(stage, stage.shape())
    np.testing.assert_array_equal(redraw_layer(original, stage.rig.neutral), original.layer)


def test_what_closes_the_neck_of_a_head_is_not_drawn_over_a_collar(stage):
    """The head is so small that its neck is in the picture, and all of it goes to one side."""
    camera = Camera(500.0, CAMERA.rotation, np.array([100.0, 150.0]))
    picture = np.random.default_rng(0).integers(0, 256, (SIDE, SIDE, 3)).astype(np.uint8)
    drawn = []
    for rig in (stage.rig, choose_parts(stage.rig, HeadChoice(("skin", "eyes", "teeth", "tongue", "lashes")))):
        aside = np.tile(np.array([0.01, 0, 0], np.float32), (1, len(rig.neutral), 1))
        depiction = Depiction(camera, rig.neutral.astype(np.float32))
        moved = replace(rig, names=("aside",), deltas=aside, depiction=depiction)
        drawn.append(redraw_picture(Original(moved, stage.template, picture), rig.neutral + aside[0]))
    np.testing.assert_array_equal(drawn[0], drawn[1])


def test_what_is_held_before_the_mouth_stays(stage):
    picture = stage.picture(stage.rig.neutral)
    regions = stage.regions(stage.rig.neutral)
    hand = np.s_[150:175, 85:115]
    picture[hand] = (20, 200, 60)
    regions[hand] = Region.OTHER
    original = stage.original(stage.shape(), picture=picture, regions=regions)
    again = redraw_picture(original, stage.shape(**OPEN))
    inner = np.s_[152:173, 87:113]
    np.testing.assert_array_equal(again[inner], picture[inner])
    assert (again[178:] != picture[178:]).any()
    # Nothing of the hand goes along with the chin.
    green = (again[..., 1].astype(int) - again[..., 0] > 60) & (again[..., 1] > again[..., 2])
    green[148:177, 83:117] = False
    assert green.sum() < 5


def test_teeth_show_where_the_mouth_opens(stage):
    original = stage.original(stage.shape())
    again = redraw_picture(original, stage.shape(**OPEN)).astype(int)
    mouth = stage.mouth(stage.shape(**OPEN))
    teeth = mouth & (stage.picture(stage.shape(**OPEN)) == FINISHES[Material.TEETH].colour).all(2)
    assert teeth.sum() > 10
    # Brighter than the dark around them, and without the red of lips.
    assert np.median(again[teeth].mean(1)) > 1.5 * np.median(again[mouth & ~teeth].mean(1))
    assert np.median(again[teeth][:, 0] - again[teeth][:, 1]) < 25


def change(gain, size=64):
    """A TextureChange that is the same everywhere."""
    flat = np.ones((size, size, 3), np.float32)
    return TextureChange(gain * flat, 0 * flat)


def test_a_change_of_paint_is_drawn_on_the_face_alone(stage):
    original = stage.original(stage.shape())
    same = redraw_picture(original, stage.shape(**OPEN))
    np.testing.assert_array_equal(redraw_picture(original, stage.shape(**OPEN), change(0)), same)
    darker = redraw_picture(original, stage.shape(**OPEN), change(-0.5))
    cheek = np.s_[120:130, 75:80]
    np.testing.assert_allclose(darker[cheek], 0.5 * same[cheek], atol=4)
    head = (stage.regions(stage.shape(**OPEN)) == Region.SKIN) | (original.regions == Region.SKIN)
    beside = cv2.dilate(head.astype(np.uint8), np.ones((5, 5))) == 0
    np.testing.assert_array_equal(darker[beside], same[beside])


def test_what_keeps_still_changes_its_paint_where_it_is_told(stage):
    original = stage.original(stage.shape())
    only = change(-0.5)
    only.gain[:, :32] = 0
    again = redraw_picture(original, stage.rig.neutral, only).astype(int)
    away = np.abs(again - original.picture).max(2)
    # The left of the chart is the left of the picture; strokes of the other side stay as they are.
    assert away[110:130, 60:90].max() == 0 and np.median(away[120:130, 115:122]) > 30


def test_drawn_teeth_take_no_paint_of_lips(stage):
    wide = {"jawOpen": 0.4, "mouthUpperUpLeft": 1, "mouthUpperUpRight": 1}
    original = stage.original(stage.shape(**wide))
    again = redraw_picture(original, stage.shape(**wide), change(-0.5))
    teeth = (original.picture == FINISHES[Material.TEETH].colour).all(2)
    inner = cv2.erode(teeth.astype(np.uint8), np.ones((3, 3))) > 0
    assert inner.any()
    np.testing.assert_array_equal(again[inner], original.picture[inner])


def test_a_head_without_texture_is_drawn_and_says_so(stage):
    bare = replace(stage, rig=replace(stage.rig, pictures=Pictures()))
    picture = stage.picture(stage.rig.neutral)
    original = bare.original(stage.shape(), picture=picture)
    assert "no texture" in original.unknown()[0]
    truth = stage.picture(stage.shape(**OPEN))
    again = redraw_picture(original, stage.shape(**OPEN))
    moved = (truth != picture).any(2) & ~stage.mouth(stage.shape(**OPEN))
    assert error(again, truth, moved) < 0.6 * error(picture, truth, moved)


def test_a_head_whose_lids_have_no_name_opens_its_mouth_all_the_same(stage):
    note = stage.template.annotation
    regions = {name: ids for name, ids in note.regions.items() if not name.startswith("eyes_")}
    plain = replace(stage, template=replace(stage.template, annotation=replace(note, regions=regions)))
    again, usual = (redraw_picture(each.original(stage.shape()), stage.shape(**OPEN)) for each in (plain, stage))
    np.testing.assert_array_equal(again, usual)


def test_what_a_picture_does_not_tell(stage):
    assert stage.original(stage.shape()).unknown() == []
    assert "mouth open" in stage.original(stage.shape(jawOpen=1.0)).unknown()[0]
    assert "eye shut" in stage.original(stage.shape(eyeBlinkLeft=1.0)).unknown()[0]


def test_a_face_that_was_edited_since_it_was_fitted_is_told(stage):
    original = stage.original(stage.shape())
    fitted = CAMERA.project(stage.rig.neutral[stage.template.annotation.landmarks[:68]])
    eye = list(EYE_LEFT)
    for size, edited in ((1.0, False), (1.5, True)):
        landmarks = fitted.copy()
        landmarks[eye] += (1 / size - 1) * (fitted[eye] - fitted[eye].mean(0))
        depiction = replace(original.depiction, landmarks=landmarks)
        notes = replace(original, rig=replace(original.rig, depiction=depiction)).unknown()
        assert ["edited after it was fitted" in note for note in notes] == [True] * edited


def test_other_pictures_are_refused(stage):
    with pytest.raises(InputError, match="found no head"):
        stage.original(stage.shape(), picture=np.zeros((60, 60, 3), np.uint8), regions=None)
    with pytest.raises(InputError, match="found no head"):
        stage.original(stage.shape(), regions=np.zeros((200, 200), np.uint8))
    with pytest.raises(InputError, match="camera"):
        replace(stage.original(stage.shape()), rig=stage.rig)


def test_drawn_teeth_keep_their_size_where_a_mouth_opens_wider(stage):
    original = stage.original(stage.shape(jawOpen=0.4, mouthUpperUpLeft=1, mouthUpperUpRight=1))
    wide = stage.shape(jawOpen=1.0, mouthUpperUpLeft=1, mouthUpperUpRight=1)
    truth = stage.picture(wide)
    again = redraw_picture(original, wide)
    white = np.array(FINISHES[Material.TEETH].colour)
    teeth, before, after = (
        (np.abs(image.astype(int) - white).max(2) < 40).sum() for image in (truth, original.picture, again)
    )
    assert before > 15 and abs(int(after) - int(before)) < 0.5 * before, (teeth, before, after)


def test_where_a_mesh_is_wider_than_the_drawn_head_what_is_behind_it_stays(stage):
    picture = stage.picture(stage.rig.neutral)
    regions = stage.regions(stage.rig.neutral)
    shown = np.flatnonzero(regions[150] == Region.SKIN)
    cut = shown[0] + 8
    picture[:, :cut] = WALL
    regions[:, :cut] = Region.BACKGROUND
    original = stage.original(stage.shape(), picture=picture, regions=regions)
    again = redraw_picture(original, stage.shape(**OPEN))
    assert (again[150:] != picture[150:]).any()
    np.testing.assert_allclose(again[140:165, : cut - 4], picture[140:165, : cut - 4], atol=3)


def test_of_an_eye_that_is_drawn_large_nothing_is_left_on_its_lids(stage):
    points = CAMERA.project(stage.rig.neutral[stage.template.annotation.landmarks]).astype(np.float32)
    eye = points[list(EYE_LEFT)]
    picture = stage.picture(stage.rig.neutral)
    regions = stage.regions(stage.rig.neutral)
    size = np.ptp(eye, axis=0)
    middle = tuple(int(x) for x in np.rint(eye.mean(0)))
    cv2.ellipse(
        picture, middle, tuple(int(x) for x in np.rint([0.75 * size[0], size[0] / 2])), 0, 0, 360, (250,) * 3, -1
    )
    cv2.ellipse(regions, middle, tuple(int(x) for x in np.rint(size / 2 + 1)), 0, 0, 360, int(Region.EYES), -1)
    original = stage.original(stage.shape(), picture=picture, regions=regions)
    depiction = replace(original.depiction, landmarks=points)
    original = replace(original, rig=replace(original.rig, depiction=depiction))
    again = redraw_picture(original, stage.shape(eyeBlinkLeft=1))
    left = (again.min(2) > 215).sum()
    assert left < 0.1 * (picture.min(2) > 215).sum()


def test_what_is_drawn_again_reaches_as_far_as_expressions_and_no_farther(stage):
    original = stage.original(stage.shape(jawOpen=0.5))
    window = original.window
    generator = np.random.default_rng(4)
    drawn = np.unique(original.faces)
    moving = drawn[np.abs(stage.rig.deltas[:, drawn]).max((0, 2)) > 1e-3]
    corner = np.array([window.left, window.top])
    ends = []
    for _ in range(50):
        weights = generator.uniform(size=len(stage.rig.names)) * (generator.random(len(stage.rig.names)) < 0.15)
        places = CAMERA.project(stage.rig.neutral + np.tensordot(weights, stage.rig.deltas, 1))[moving]
        ends += [places.min(0), places.max(0)]
    assert (np.min(ends, axis=0) >= corner).all()
    assert (np.max(ends, axis=0) <= corner + [window.width, window.height]).all()
    usual = np.ptp(original.placed[drawn, :2], axis=0)
    # Nothing moves far to the sides.
    assert window.width < 1.15 * usual[0]
