import numpy as np
import pytest

from caricli.methods.hair.parsed_hair import parsed_hair
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


def test_hair_hangs_on_the_head(face, pixels):
    hair = (Region.HAIR, (5, 25), (15, 65))
    regions = labels(
        hair, (Region.SKIN, (25, 70), (15, 65)), (Region.HAIR, (5, 25), (80, 90)), (Region.HAIR, (60, 62), (40, 42))
    )
    mask = parsed_hair(face, regions, pixels)
    np.testing.assert_array_equal(mask.pixels, labels(hair) > 0)
    np.testing.assert_array_equal(mask.behind, regions == Region.BACKGROUND)
    assert mask.trusted and mask.doubt == 0


def test_a_hat_is_no_hair_and_makes_it_doubtful(face, pixels):
    regions = labels(
        (Region.HAT, (5, 30), (15, 65)), (Region.SKIN, (30, 70), (15, 65)), (Region.HAIR, (30, 40), (15, 25))
    )
    mask = parsed_hair(face, regions, pixels)
    assert not mask.pixels[regions == Region.HAT].any() and mask.pixels.sum() == 100
    assert mask.doubt > 0.5 and not mask.trusted


def test_a_bald_head_has_none(face, pixels):
    mask = parsed_hair(face, labels((Region.SKIN, (15, 70), (15, 65))), pixels)
    assert not mask.pixels.any() and not mask.trusted
