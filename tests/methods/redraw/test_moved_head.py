from dataclasses import replace

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
