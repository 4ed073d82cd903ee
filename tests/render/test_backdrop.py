import numpy as np

from caricli.render.backdrop import PAPER, backdrop, on_backdrop, row_of


def test_neighbours_show_no_border_and_the_middle_is_brighter():
    picture = backdrop(90, 60).astype(int)
    edges = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
    assert all(np.abs(edge - PAPER).max() <= 1 for edge in edges)
    assert (picture >= PAPER).all() and (picture[40, 30] > np.array(PAPER) + 15).all()
    np.testing.assert_array_equal(picture, picture[:, ::-1])


def test_what_has_alpha_stands_before_it_and_the_rest_stays():
    full = np.full((8, 8, 4), 255, np.uint8)
    full[:, :4, 3] = 0
    drawn = on_backdrop(full)
    np.testing.assert_array_equal(drawn[:, :4], backdrop(8, 8)[:, :4])
    assert (drawn[:, 4:] == 255).all()
    photo = np.full((8, 8, 3), 9, np.uint8)
    assert on_backdrop(photo) is photo
    np.testing.assert_array_equal(row_of([full, photo]), np.hstack([drawn, photo]))
