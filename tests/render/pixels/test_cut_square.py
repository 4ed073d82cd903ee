import numpy as np
import pytest

from caricli.render.backdrop import PAPER
from caricli.render.pixels.cut_square import cut_square


def test_a_square_of_its_own_size_is_as_it_was():
    picture = np.random.default_rng(0).integers(0, 256, (40, 50, 3), np.uint8)
    np.testing.assert_array_equal(cut_square(picture, np.array([10.0, 5.0]), 20.0, 20), picture[5:25, 10:30])


@pytest.mark.parametrize("side", [300, 1000, 2000])
def test_thin_lines_stay_whole(side):
    picture = np.full((side, side, 3), 255, np.uint8)
    rows = np.arange(side)
    for aside in range(max(side // 500, 1)):
        picture[rows, (rows * 7 // 10 + aside) % side] = 0
    small = cut_square(picture, np.zeros(2), float(side), 100)
    darkest = small[..., 0].min(axis=1).astype(int)
    assert darkest.max() < 235 and np.ptp(darkest) < 90


def test_beyond_the_picture_is_paper():
    square = cut_square(np.zeros((30, 30, 3), np.uint8), np.array([-30.0, -30.0]), 90.0, 30)
    assert (square[:9] == PAPER).all() and (square[12:18, 12:18] == 0).all()
