import numpy as np
import pytest

from caricli.methods.texture.seen_eyes import seen_eyes
from caricli.structures.parsing import Region
from tests.render.eyes.test_iris_radius import eyes


@pytest.mark.parametrize("before", [Region.GLASSES, Region.HAT, Region.HAIR, Region.OTHER])
def test_an_eye_behind_something_is_not_seen(before):
    image, marks = eyes(10)
    regions = np.full(image.shape[:2], Region.SKIN, np.uint8)
    regions[:, :105] = before
    seen = seen_eyes(marks, regions)
    assert np.isnan(seen[36:42]).all()
    np.testing.assert_array_equal(seen[42:], marks[42:])
    np.testing.assert_array_equal(seen[:36], marks[:36])


def test_rims_and_eyes_that_are_not_known_change_nothing():
    image, marks = eyes(10)
    regions = np.full(image.shape[:2], Region.EYES, np.uint8)
    regions[:, 55:62] = Region.GLASSES
    marks[42] = np.nan
    np.testing.assert_array_equal(seen_eyes(marks, regions), marks)


def test_closed_eyes_are_not_seen_but_half_of_one_open_eye_shows_both():
    image, marks = eyes(10)
    regions = np.full(image.shape[:2], Region.SKIN, np.uint8)
    np.testing.assert_array_equal(seen_eyes(marks, regions), marks)
    left, top = np.floor(marks[36:42].min(0)).astype(int)
    regions[top, left] = Region.EYES
    seen = seen_eyes(marks, regions)
    assert np.isnan(seen[36:48]).all()
    np.testing.assert_array_equal(seen[:36], marks[:36])
    regions[:, : int(marks[36:42, 0].mean())] = Region.EYES
    np.testing.assert_array_equal(seen_eyes(marks, regions), marks)
