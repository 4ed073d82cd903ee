import cv2
import numpy as np
import pytest

from caricli.methods.detect.eye_liner import eye_liner

SIDE = 128
MIDDLE = (64, 64)
INK = 30


def drawn(*shapes):
    """(S, S) bool, polygons of (x, y) corners."""
    canvas = np.zeros((SIDE, SIDE), np.uint8)
    for shape in shapes:
        cv2.fillPoly(canvas, [np.array(shape)], 1)
    return canvas > 0


@pytest.fixture
def eye():
    canvas = np.zeros((SIDE, SIDE), np.uint8)
    cv2.ellipse(canvas, MIDDLE, (20, 8), 0, 0, 360, 1, -1)
    return canvas > 0


WEDGE = drawn([(80, 58), (94, 58), (86, 66)])
OTHER_WEDGE = drawn([(48, 58), (34, 58), (42, 66)])
FOLD = drawn([(84, 63), (127, 63), (127, 66), (84, 66)])
APART = drawn([(92, 60), (96, 60), (96, 66), (92, 66)])


@pytest.mark.parametrize(
    ("ink", "share"), [(WEDGE, 0.9), (OTHER_WEDGE, 0.9), (FOLD, 0), (APART, 0), (np.zeros_like(FOLD), 0)]
)
def test_ink_that_ends_beside_an_eye_prolongs_it(eye, ink, share):
    lightness = np.where(ink, INK, 180)
    liner = eye_liner(lightness, eye, ~eye, np.zeros_like(eye))
    assert not (liner & ~ink).any() and not (liner & eye).any()
    beyond = ink & ~eye
    assert liner.sum() >= share * beyond.sum() and (share or not liner.any())


def test_what_is_kept_or_hardly_darker_is_no_ink(eye):
    lightness = np.where(WEDGE, INK, 180)
    assert not eye_liner(lightness, eye, ~eye, WEDGE).any()
    assert not eye_liner(np.where(WEDGE, 130, 180), eye, ~eye, np.zeros_like(eye)).any()


def test_without_skin_nothing_is_darker(eye):
    nothing = np.zeros_like(eye)
    assert not eye_liner(np.where(WEDGE, INK, 180), eye, nothing, nothing).any()


def test_specks_have_no_corners():
    speck = drawn([(60, 60), (63, 60), (63, 63), (60, 63)])
    assert not eye_liner(np.where(WEDGE, INK, 180), speck, ~speck, np.zeros_like(speck)).any()
