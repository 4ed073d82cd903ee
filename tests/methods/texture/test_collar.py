from itertools import product

import numpy as np
import pytest

from caricli.methods.texture.collar import find_collar
from caricli.structures.parsing import Region

SHADES = np.array(list(product([0, 128, 255], repeat=3)), np.uint8)
"""Far from each other."""


@pytest.fixture(scope="module")
def portrait():
    """Labels, pixels and numbers of shades: skin that has more of every further shade, above a neck that has all."""
    generator = np.random.default_rng(0)
    shares = np.linspace(0.5, 1.5, len(SHADES)) / len(SHADES)
    numbers = generator.choice(len(SHADES), (60, 83), p=shares)
    regions = np.full(numbers.shape, np.uint8(Region.SKIN))
    regions[40:] = Region.NECK
    return regions, SHADES[numbers], numbers


def collar_of(regions, pixels):
    return find_collar(regions, np.ones(regions.shape, bool), pixels)


def test_what_of_a_neck_has_a_colour_that_the_skin_hardly_has_is_a_collar(portrait):
    regions, pixels, numbers = portrait
    skin = regions == Region.SKIN
    rare = np.bincount(numbers[skin], minlength=len(SHADES)) < 0.03 * skin.sum()
    assert 3 < rare.sum() < 15
    np.testing.assert_array_equal(collar_of(regions, pixels), rare[numbers] & ~skin)


def test_the_mirror_image_and_a_larger_copy_have_the_same_collar(portrait):
    regions, pixels, _ = portrait
    collar = collar_of(regions, pixels)
    np.testing.assert_array_equal(collar_of(regions[:, ::-1], pixels[:, ::-1])[:, ::-1], collar)
    larger = (each.repeat(2, 0).repeat(3, 1) for each in (regions, pixels))
    np.testing.assert_array_equal(collar_of(*larger)[::2, ::3], collar)


def test_without_skin_or_neck_there_is_none(portrait):
    regions, pixels, _ = portrait
    for only in (Region.SKIN, Region.NECK):
        assert not collar_of(np.full_like(regions, only), pixels).any()
