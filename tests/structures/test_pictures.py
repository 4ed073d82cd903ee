import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Material, Pictures
from caricli.structures.materials import FINISHES

LIGHT = np.full((2, 3, 3), 200, np.uint8)
DARK = np.full((2, 3, 3), 100, np.uint8)


def test_pictures_of_one_size_are_mixed_by_their_weight():
    mixed = Pictures(LIGHT).mixed(Pictures(DARK), 0.25)
    assert (mixed.skin == 175).all() and mixed.skin.dtype == np.uint8 and mixed.eyes is None


def test_else_the_nearer_or_the_only_one_is_taken():
    large = np.full((5, 5, 3), 9, np.uint8)
    for weight, expected in ((0.4, LIGHT), (0.5, LIGHT), (0.6, large)):
        assert Pictures(LIGHT).mixed(Pictures(large), weight).skin is expected
    assert Pictures().mixed(Pictures(LIGHT), 0.1).skin is LIGHT and Pictures(LIGHT).mixed(Pictures(), 0.9).skin is LIGHT
    assert Pictures(LIGHT).mixed(Pictures(LIGHT.copy()), 0.3).skin is LIGHT


def test_whether_they_are_the_same():
    assert Pictures(LIGHT).same(Pictures(LIGHT.copy())) and Pictures().same(Pictures())
    assert not Pictures(LIGHT).same(Pictures(DARK)) and not Pictures(LIGHT).same(Pictures(LIGHT, DARK))
    assert Pictures(LIGHT) and Pictures(eyes=DARK) and not Pictures()


@pytest.mark.parametrize("image", [LIGHT.astype(float), LIGHT[0], LIGHT[:0], LIGHT[..., :2]])
def test_what_is_no_picture_is_refused(image):
    with pytest.raises(InputError, match=r"eyes: expected \(H,W,3\) uint8"):
        Pictures(eyes=image)


def test_what_is_plain_beside_a_grey_skin_is_grey():
    """A black-and-white drawing has no red tongue."""
    tan = np.tile(np.array([206, 160, 136], np.uint8), (8, 8, 1))
    assert Pictures().coloured == Pictures(tan).coloured == 1 and Pictures(DARK).coloured == 0
    assert Pictures(tan).finish(Material.TONGUE) == FINISHES[Material.TONGUE] and not Pictures(tan).finishes
    red, green, blue = Pictures(DARK).finish(Material.TONGUE).colour
    assert red == green == blue == round(np.mean(FINISHES[Material.TONGUE].colour))
    pale = Pictures(np.tile(np.array([210, 205, 200], np.uint8), (8, 8, 1)))
    assert 0 < pale.coloured < 1
    red, _, blue = pale.finishes["tongue"].colour
    assert 0 < red - blue < FINISHES[Material.TONGUE].colour[0] - FINISHES[Material.TONGUE].colour[2]


def test_paper_and_unused_texels_make_no_skin_grey():
    most = np.zeros((10, 10, 3), np.uint8)
    most[:3] = 206, 160, 136
    assert Pictures(np.kron(most, np.ones((4, 4, 1), np.uint8))).coloured == 1


def test_eyes_beside_a_grey_skin_are_toned():
    brown = np.tile(np.array([148, 110, 94], np.uint8), (8, 8, 1))
    tan = np.tile(np.array([206, 160, 136], np.uint8), (8, 8, 1))
    np.testing.assert_array_equal(Pictures(tan, brown).with_toned_eyes().eyes, brown)
    assert (Pictures(DARK, brown).with_toned_eyes().eyes == 117).all()
    assert Pictures(DARK).with_toned_eyes().eyes is None
