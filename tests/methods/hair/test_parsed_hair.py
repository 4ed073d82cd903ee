from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.hair.parsed_hair import is_before_head, parsed_hair
from caricli.structures import Camera, Face
from caricli.structures.parsing import Region


@pytest.fixture
def face(head_template):
    """A face of 40 pixels in a picture."""
    points = np.random.default_rng(0).uniform(20, 60, (68, 2))
    return Face(head_template, Camera(200.0, np.diag([1.0, -1, -1]), np.array([40.0, 40.0])), points)


@pytest.fixture
def pixels():
    mask = np.zeros((90, 90), bool)
    mask[15:70, 15:65] = True
    return mask


def labels(*boxes):
    regions = np.zeros((90, 90), np.uint8)
    for region, rows, columns in boxes:
        regions[slice(*rows), slice(*columns)] = region
    return regions


def painted(regions):
    """A picture in the colours of regions, with some grain."""
    colours = {Region.HAIR: (60, 40, 30), Region.SKIN: (220, 170, 140), Region.HAT: (30, 60, 160)}
    image = np.full((*regions.shape, 3), (170, 200, 210))
    for region, colour in colours.items():
        image[regions == region] = colour
    grain = np.random.default_rng(1).normal(0, 3, regions.shape)[..., None]
    return np.clip(image + grain, 0, 255).astype(np.uint8)


def test_hair_hangs_on_the_head(face, pixels):
    hair = (Region.HAIR, (5, 25), (15, 65))
    regions = labels(
        hair, (Region.SKIN, (25, 70), (15, 65)), (Region.HAIR, (5, 25), (80, 90)), (Region.HAIR, (60, 62), (40, 42))
    )
    mask = parsed_hair(face, regions, pixels, painted(regions))
    np.testing.assert_array_equal(mask.pixels, labels(hair) > 0)
    assert mask.behind[regions == Region.BACKGROUND].all() and not mask.behind[regions == Region.SKIN].any()
    assert mask.trusted and mask.doubt == 0


def test_a_lock_that_a_line_cuts_off_hangs_on_the_head_and_one_farther_away_does_not(face, pixels):
    hair = (Region.HAIR, (5, 25), (15, 65))
    skin = (Region.SKIN, (25, 70), (15, 65))
    near, far = ((Region.HAIR, (first, first + 3), (15, 17)) for first in (26, 40))
    regions = labels(hair, skin, near, far)
    mask = parsed_hair(face, regions, pixels, painted(regions))
    np.testing.assert_array_equal(mask.pixels, labels(hair, near) > 0)


def test_beside_much_of_a_hat_colours_decide(face, pixels):
    regions = labels(
        (Region.HAT, (5, 30), (15, 65)), (Region.SKIN, (30, 70), (15, 65)), (Region.HAIR, (30, 40), (15, 25))
    )
    assert parsed_hair(face, regions, pixels, painted(regions)) is None
    small = labels(
        (Region.HAT, (29, 30), (15, 40)), (Region.SKIN, (30, 70), (15, 65)), (Region.HAIR, (30, 40), (15, 25))
    )
    mask = parsed_hair(face, small, pixels, painted(small))
    assert not mask.pixels[small == Region.HAT].any() and mask.pixels.sum() == 100
    assert mask.doubt > 0.99 * 25 / 125


def test_a_speck_of_a_hat_in_colours_of_the_hair_is_hair(face, pixels):
    """These are of two colours, of which the speck has one."""
    regions = labels((Region.HAIR, (5, 25), (15, 65)), (Region.SKIN, (25, 70), (15, 65)))
    image = painted(regions)
    image[5:25, 15:40] += np.array([30, 30, 0], np.uint8)
    speck = labels((Region.HAT, (12, 16), (61, 65))) > 0
    regions[speck] = Region.HAT
    assert parsed_hair(face, regions, pixels, image).pixels[speck].all()
    regions[5:18, 15:24] = Region.HAT
    assert not parsed_hair(face, regions, pixels, image).pixels[speck].any()


def test_places_of_hair_that_are_labelled_hat_are_hair_if_they_have_its_colour(face, pixels):
    """Two of them, together a fifth of the hair; the upper half of it, in its colour, is a hat."""
    hair = labels((Region.HAIR, (5, 25), (15, 65)))
    skin = labels((Region.SKIN, (25, 70), (15, 65)))
    patches = labels((1, (5, 17), (17, 26)), (1, (5, 17), (54, 63))) > 0
    upper = labels((1, (5, 14), (15, 65))) > 0
    for hat, colours, whole in ((patches, hair, True), (patches, np.where(patches, Region.HAT, hair), False),
                                (upper, hair, False)):  # fmt: skip
        regions = (np.where(hat, Region.HAT, hair) + skin).astype(np.uint8)
        mask = parsed_hair(face, regions, pixels, painted(colours + skin))
        taken = 0.0 if mask is None else mask.pixels[hat].mean()
        assert (taken > 0.9) == whole


def test_a_wall_beside_the_hair_is_no_hat(face, pixels):
    hair = (Region.HAIR, (5, 25), (15, 65))
    regions = labels(hair, (Region.SKIN, (25, 70), (15, 65)), (Region.HAT, (0, 20), (65, 80)))
    mask = parsed_hair(face, regions, pixels, painted(regions))
    np.testing.assert_array_equal(mask.pixels, labels(hair) > 0)
    assert mask.behind[regions == Region.HAT].all() and mask.doubt == 0


def test_a_wall_that_passes_for_hat_and_hair_says_nothing_of_hair(face, pixels):
    """They are beside the head, next to each other."""
    regions = labels(
        *((Region.HAT, (0, 30), (0, 12)), (Region.HAT, (0, 30), (68, 90)), (Region.HAIR, (0, 17), (12, 68))),
        (Region.SKIN, (17, 70), (15, 65)),
    )
    assert not is_before_head(parsed_hair(face, regions, pixels, painted(regions)), pixels)


def test_a_wall_above_a_bald_head_is_not_its_hair(face, pixels):
    wall, hair = (labels((Region.HAIR, (0, last), (5, 75)), (Region.SKIN, (last, 70), (15, 65))) for last in (17, 25))
    assert not is_before_head(parsed_hair(face, wall, pixels, painted(wall)), pixels)
    assert is_before_head(parsed_hair(face, hair, pixels, painted(hair)), pixels)


def test_hair_before_a_wall_of_its_colour_ends_where_the_regions_say(face, pixels):
    regions = labels((Region.HAIR, (5, 25), (15, 65)), (Region.SKIN, (25, 70), (15, 65)))
    image = painted(np.where(regions == Region.BACKGROUND, Region.HAIR, regions))
    mask = parsed_hair(face, regions, pixels, image)
    wrong = mask.pixels != (regions == Region.HAIR)
    assert mask.trusted and wrong.sum() < 0.1 * (regions == Region.HAIR).sum()
    assert not wrong[24:].any()


def test_brows_next_to_hair_are_none(face, pixels):
    """Brows in the colour of the hair that they touch."""
    points = face.landmarks.copy()
    points[17:27] = np.column_stack([np.linspace(28, 52, 10), np.full(10, 27)])
    regions = labels((Region.HAIR, (5, 25), (15, 65)), (Region.SKIN, (25, 70), (15, 65)))
    image = painted(np.where(labels((Region.HAIR, (25, 29), (28, 52))) > 0, Region.HAIR, regions))
    mask = parsed_hair(replace(face, landmarks=points), regions, pixels, image)
    assert mask.pixels[6:24, 17:63].all() and not mask.pixels[26:28, 30:38].any()


def test_a_bald_head_has_none(face, pixels):
    regions = labels((Region.SKIN, (15, 70), (15, 65)))
    mask = parsed_hair(face, regions, pixels, painted(regions))
    assert not mask.pixels.any() and not mask.trusted and is_before_head(mask, pixels)


def test_hair_ends_where_the_picture_says(face, pixels):
    """Regions are a few pixels too small on one side, and too large on the other."""
    skin = (Region.SKIN, (25, 70), (15, 65))
    true = labels((Region.HAIR, (5, 25), (15, 65)), skin)
    coarse = labels((Region.HAIR, (5, 25), (18, 68)), skin)
    mask = parsed_hair(face, coarse, pixels, painted(true))
    wrong = (mask.pixels != (true == Region.HAIR)).sum()
    assert wrong < 0.2 * (coarse != true).sum()
    assert mask.behind[6:24, 66:68].all() and not mask.behind[6:24, 16:64].any()


def test_hair_that_has_no_colour_of_its_own_is_doubted(face, pixels):
    """A strip that is half of the wall, half of the skin."""
    skin = (Region.SKIN, (25, 70), (15, 65))
    strip = labels(skin, (Region.HAIR, (22, 28), (15, 65)))
    assert parsed_hair(face, strip, pixels, painted(labels(skin))) is None
