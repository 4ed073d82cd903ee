from types import SimpleNamespace

import numpy as np
import pytest

from caricli.methods.redraw.tooth_rows import _below


def mouth_of(rows, height):
    """An Original of whose mouth of so many samples only the brightness of each row counts."""
    mouth = np.zeros((height + 10, 60), bool)
    mouth[5 : 5 + height, 10:50] = True
    picture = np.full((*mouth.shape, 3), 160.0)
    picture[5 : 5 + height] = rows(np.arange(height) / height)[:, None, None]
    return SimpleNamespace(mouth=mouth, picture=picture, window=SimpleNamespace(sampled=lambda image: image))


@pytest.mark.parametrize("height", [8, 20, 33, 80])
def test_where_nothing_is_dark_upper_teeth_fill_a_mouth_of_any_height(height):
    original = mouth_of(lambda share: 150 + 40 * share, height)
    assert not _below(original)[original.mouth].any()


@pytest.mark.parametrize("height", [20, 33, 80])
def test_below_a_dark_gap_it_goes_with_the_jaw(height):
    original = mouth_of(lambda share: np.where(abs(share - 0.55) < 0.06, 60.0, 170.0), height)
    below = _below(original)[5 : 5 + height, 30]
    first = int(np.flatnonzero(below)[0])
    assert 0.45 < first / height < 0.67 and below[first:].all()
