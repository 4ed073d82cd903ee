from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.methods.redraw.moved_head import MovedHead, _at
from caricli.methods.redraw.view import Window
from caricli.methods.texture.estimate_light import Light
from caricli.structures.landmarks import EYE_LEFT
from caricli.structures.parsing import Region
from tests.methods.redraw.conftest import CAMERA


@pytest.mark.parametrize("fine", [1, 3])
def test_samples_are_found_again_at_their_places(fine):
    window = Window(7, 5, 6, 4, fine)
    rows, columns = np.indices((4 * fine, 6 * fine))
    np.testing.assert_allclose(_at(window.places, window), [columns, rows], atol=1e-4)


@pytest.mark.parametrize(("degrees", "brighter"), [(25, True), (-25, False)])
def test_what_turns_to_the_light_becomes_brighter(stage, degrees, brighter):
    """To light from the left of the face, or away from it."""
    original = stage.original(stage.shape())
    original.__dict__["light"] = Light(
        np.array([[3.0] * 3, [1.5] * 3, *[[0.0] * 3] * 7]), np.tile([[0.3], [2.5]], 3), 1.0
    )
    turned = stage.rig.neutral @ Rotation.from_euler("y", degrees, degrees=True).as_matrix().T
    head = MovedHead(original, turned)
    front = head.light_ratio[head.view.covered & (head.shown > 0.9)]
    assert (np.median(front) > 1.05) == brighter and (np.median(front) < 0.95) != brighter


def test_a_mouth_is_dark_in_its_depth_alone(stage):
    original = stage.original(stage.shape())
    original.__dict__["light"] = None
    head = MovedHead(original, stage.shape(jawOpen=1.0))
    assert np.quantile(head.shade[head.view.inside], 0.1) < 0.7
    np.testing.assert_allclose(head.shade[head.view.covered & ~head.view.inside].mean(), 1, atol=0.02)


def test_lashes_are_drawn_on_an_eye_that_closes_alone(stage):
    original = stage.original(stage.shape())
    assert not MovedHead(original, stage.shape(jawOpen=0.8)).lashes.any()
    head = MovedHead(original, stage.shape(eyeBlinkLeft=1.0))
    columns = np.nonzero(head.lashes > 0.3)[1]
    # The left eye is on the right of the picture.
    assert len(columns) > 20 and original.window.places[0, columns.min(), 0] > CAMERA.translation[0]


@pytest.fixture
def eyed(stage):
    """An Original whose label map shows an eye, with a brow right above it; and their pixels."""
    points = CAMERA.project(stage.rig.neutral[stage.template.annotation.landmarks]).astype(np.float32)
    eye = np.round(points[list(EYE_LEFT)].mean(0)).astype(int)
    regions = stage.regions(stage.rig.neutral)
    places = (
        np.s_[eye[1] - 3 : eye[1] + 4, eye[0] - 8 : eye[0] + 9],
        np.s_[eye[1] - 7 : eye[1] - 3, eye[0] - 8 : eye[0] + 9],
    )
    for place, region in zip(places, (Region.EYES, Region.BROWS), strict=True):
        regions[place] = region
    original = stage.original(stage.shape(), regions=regions)
    depiction = replace(original.depiction, landmarks=points)
    return replace(original, rig=replace(original.rig, depiction=depiction)), *places


def test_an_open_eye_is_no_mouth_and_a_brow_no_rim_of_it(eyed):
    original, eye, brow = eyed
    means = original.window.means
    corner = np.array([original.window.top, original.window.left])
    shown = {}
    for name, values in (("mouth", original.mouth), ("openings", original.openings), ("rims", original.rims)):
        for part, place in (("eye", eye), ("brow", brow)):
            rows, columns = (slice(s.start - c, s.stop - c) for s, c in zip(place, corner, strict=True))
            shown[name, part] = means(values.astype(np.float32))[rows, columns]
    assert shown["openings", "eye"].mean() > 0.8 and shown["mouth", "eye"].max() == 0
    assert np.median(shown["rims", "brow"][0]) < 0.3


def test_what_the_drawing_left_out_is_head_where_it_has_gone_farther_in(stage):
    """A mesh wider than the drawn head, whose side turns to the front."""
    regions = stage.regions(stage.rig.neutral)
    regions[:, : np.flatnonzero(regions[150] == Region.SKIN)[0] + 8] = Region.BACKGROUND
    original = stage.original(stage.shape(), regions=regions)
    turned = stage.rig.neutral @ Rotation.from_euler("y", 50, degrees=True).as_matrix().T
    still, head = (MovedHead(original, shape) for shape in (stage.rig.neutral, turned))
    assert still.solid[still.view.covered & (original.apart > 0.99)].max() < 0.01
    beside = head.look(original.apart) > 0.99
    farther = head.view.inwards - head.look(original.view.inwards)
    reach = original.settings.line * original.size * original.window.fine
    inner = beside & head.view.covered & (farther > 2 * reach)
    assert inner.sum() > 200 and head.solid[inner].min() > 0.99


def test_lines_between_what_was_hidden_tell_no_colours(stage):
    original = stage.original(stage.shape())
    head = MovedHead(original, stage.rig.neutral)
    middle = tuple(size // 2 for size in head.view.face.shape)
    shown = np.zeros(head.view.face.shape, np.float32)
    shown[middle[0] - 20 : middle[0] + 20, middle[1] - 20 : middle[1] + 20] = 1
    shown[middle[0] - 60, middle[1] - 40 : middle[1] + 40] = 1
    head.__dict__["shown"] = shown
    assert head.told[middle] == 1 and not head.told[middle[0] - 60].any()
    # Nor does what is so near to the background that an outline is drawn there.
    head = MovedHead(original, stage.rig.neutral)
    head.__dict__["shown"] = np.ones_like(shown)
    assert head.told[middle] == 1 and head.told[original.beyond > 0.99].max() < 0.01
    assert (head.told < 0.5).sum() > (original.beyond > 0.5).sum() + 50


def test_background_inside_of_a_label_map_is_no_skin(stage):
    """A label map that takes two pixels beside the drawn head for skin."""
    right = stage.original(stage.shape())
    labels = cv2.dilate((right.regions == Region.SKIN).astype(np.uint8), np.ones((5, 5)))
    regions = np.where(labels > 0, Region.SKIN, Region.BACKGROUND).astype(np.uint8)
    wrong = stage.original(stage.shape(), regions=regions)
    fine = wrong.window.fine
    missed = wrong.window.cut((regions != right.regions).astype(np.uint8)).repeat(fine, 0).repeat(fine, 1)
    missed = cv2.erode(missed, np.ones((3, 3)))
    assert missed.sum() > 100 and np.median(wrong.beside[missed > 0]) > 0.85
    skin = cv2.erode(right.window.sampled((right.regions == Region.SKIN).astype(np.uint8)), np.ones((9, 9)))
    near = cv2.dilate(right.beyond, right.disc(right.settings.stain)) * skin > 0.9
    assert near.sum() > 100 and np.median(right.beside[near]) < 0.3
    head = MovedHead(wrong, stage.rig.neutral)
    assert np.median(head.told[missed > 0]) < 0.2
