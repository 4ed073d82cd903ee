import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Cues
from caricli.structures.cues import SHAPES, viseme_name


def test_there_are_fifteen_visemes_and_nine_letters():
    assert len(set(SHAPES)) == 24 and SHAPES[:9] == tuple(f"rhubarb_{letter}" for letter in "ABCDEFGHX")


@pytest.mark.parametrize(
    ("name", "viseme"),
    [("PP", "PP"), ("viseme_pp", "PP"), ("SIL", "sil"), ("viseme_I", "ih"), ("O", "oh"), ("u", "ou"), ("e", "E")],
)
def test_visemes_have_several_spellings(name, viseme):
    assert viseme_name(name) == f"viseme_{viseme}"


@pytest.mark.parametrize("name", ["A", "", "viseme_", "jawOpen"])
def test_other_names_are_no_visemes(name):
    assert viseme_name(name) is None


@pytest.mark.parametrize(
    ("names", "starts", "end"),
    [
        ((), [], 1),
        (("PP",), [0], 1),
        (("viseme_PP",), [0.1], 1),
        (("viseme_PP",), [0], 0),
        (("viseme_PP",), [0], np.inf),
        (("viseme_PP", "viseme_aa"), [0], 1),
        (("viseme_PP", "viseme_aa"), [0, 0], 1),
    ],
)
def test_parts_that_do_not_fit_are_refused(names, starts, end):
    with pytest.raises(InputError, match="cues: expected"):
        Cues(names, np.array(starts, float), end)
