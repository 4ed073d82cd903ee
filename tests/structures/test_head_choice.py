import numpy as np

from caricli.structures import HeadChoice, Material
from caricli.structures.head_choice import BARE, WHOLE


def test_all_that_a_head_is_made_of():
    assert WHOLE.materials == [*Material] and BARE.materials == [Material.SKIN]
    assert HeadChoice(("teeth", "skin")).materials == [Material.SKIN, Material.TEETH, Material.GUMS]


def test_shoulders_are_wanted_whether_the_bust_is_named_or_not():
    assert HeadChoice(("skin",), shoulders=True).materials == [Material.SKIN, Material.BUST, Material.CLOTH]
    assert HeadChoice(shoulders=True).materials == WHOLE.materials


def test_all_polygons_must_be_wanted():
    choice = HeadChoice(("skin", "hair"))
    assert choice.takes(np.array([0, 6, 6])) and choice.takes(np.array([]))
    assert not choice.takes(np.array([0, 6, 2]))
