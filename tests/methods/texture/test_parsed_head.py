import numpy as np
import pytest

from caricli.methods.texture.parsed_head import parsed_head
from caricli.structures.parsing import Region


@pytest.fixture
def regions():
    """A head with hair, glasses, a hat and a hand before it, and somebody else beside it."""
    labels = np.zeros((60, 80), np.uint8)
    labels[10:50, 10:40] = Region.SKIN
    labels[6:16, 10:40] = Region.HAIR
    labels[2:6, 10:40] = Region.HAT
    labels[25:28, 12:38] = Region.GLASSES
    labels[42:55, 5:20] = Region.OTHER
    labels[50:60, 10:40] = Region.CLOTH
    labels[10:50, 55:75] = Region.SKIN
    return labels


@pytest.fixture
def image():
    """Of skin all over."""
    return np.full((60, 80, 3), (205, 150, 120), np.uint8)


@pytest.fixture
def pixels():
    """What the mesh covers."""
    mask = np.zeros((60, 80), bool)
    mask[8:50, 10:40] = True
    return mask


def test_what_is_worn_or_held_is_of_the_head_but_no_paint(regions, pixels, image):
    head = parsed_head(regions, pixels, image)
    assert not (head.paint & ~head.whole).any()
    for kind in (Region.GLASSES, Region.HAT):
        assert head.whole[regions == kind].all() and not head.paint[regions == kind].any()
    assert head.paint[regions == Region.HAIR].all()
    held = regions == Region.OTHER
    np.testing.assert_array_equal(head.whole[held], pixels[held])
    assert not head.paint[held].any()
    assert not head.whole[np.isin(regions, (Region.BACKGROUND, Region.CLOTH))].any()


def test_other_people_are_other_heads(regions, pixels, image):
    head = parsed_head(regions, pixels, image)
    assert not head.whole[:, 50:].any() and head.whole[:, :50].any()


def test_a_head_that_was_not_seen_is_none(regions, pixels, image):
    assert parsed_head(regions, np.zeros_like(pixels), image) is None
    assert parsed_head(np.zeros_like(regions), pixels, image) is None


def test_a_collar_that_was_taken_for_neck_is_no_paint(regions, pixels, image):
    regions[42:50, 22:40] = Region.NECK
    image[42:50, 22:32] = (110, 80, 60)  # in shadow, as the skin's own
    image[20:24, 15:35] = (110, 80, 60)
    image[42:50, 32:40] = (190, 20, 30)
    head = parsed_head(regions, pixels, image)
    assert head.paint[42:50, 22:32].all() and not head.paint[42:50, 32:40].any()
    assert head.whole[42:50, 22:40].all()


def test_what_is_beyond_a_collar_is_no_neck(image):
    labels = np.zeros((400, 200), np.uint8)
    labels[20:300, 50:150] = Region.SKIN
    labels[300:400, 50:150] = Region.NECK
    picture = np.full((400, 200, 3), image[0, 0], np.uint8)
    picture[330:345, 50:150] = 250  # a shirt, and below it a jacket of the skin's colour
    head = parsed_head(labels, labels > 0, picture)
    assert head.paint[300:327, 55:145].all() and not head.paint[329:].any()
    assert head.whole[300:, 50:150].all()


def test_a_collar_is_no_paint_beyond_the_mesh(regions, pixels, image):
    """The outermost vertices see pixels beside the mesh, too."""
    regions[42:56, 22:40] = Region.NECK
    image[42:56, 32:40] = (190, 20, 30)
    head = parsed_head(regions, pixels, image)
    assert head.paint[42:49, 22:30].all() and not head.paint[42:56, 32:40].any()
    assert head.whole[42:50, 22:40].all()


def test_what_is_behind_the_head_is_no_paint_at_its_border(image):
    paper = (240, 240, 240)
    regions = np.full((200, 200), Region.BACKGROUND, np.uint8)
    regions[20:180, 40:160] = Region.SKIN
    picture = np.full((200, 200, 3), paper, np.uint8)
    picture[20:180, 44:160] = image[0, 0]
    picture[90:110, 90:110] = paper  # light on the skin
    picture[60:100, 150:160] = (20, 20, 20)  # a line around it
    pixels = regions == Region.SKIN
    head = parsed_head(regions, pixels, picture)
    assert head.whole[pixels].all()
    assert not head.paint[25:175, 40:43].any()
    assert head.paint[25:175, 45:155].all() and head.paint[60:100, 150:160].all()
    picture[:] = image[0, 0]
    assert parsed_head(regions, pixels, picture).paint[pixels].all()


def test_a_speck_punches_no_hole_but_one_at_the_border_is_no_paint(image):
    paper = (240, 240, 240)
    regions = np.full((200, 200), Region.BACKGROUND, np.uint8)
    regions[20:180, 40:160] = Region.SKIN
    picture = np.full((200, 200, 3), paper, np.uint8)
    picture[20:180, 40:160] = image[0, 0]
    picture[100, 42] = paper
    picture[120:122, 155] = paper
    picture[60, 40:43] = paper
    picture[140:150, 41:43] = paper
    paint = parsed_head(regions, regions == Region.SKIN, picture).paint
    assert paint[100, 42] and paint[120:122, 155].all()
    assert not paint[60, 40:43].any() and not paint[141:149, 41:43].any()
