import numpy as np

from caricli.methods.redraw.spread_colours import box_around, spread_colours


def ramp():
    """(60, 90, 2) float32 values that grow evenly along rows and columns."""
    rows, columns = np.indices((60, 90), np.float32)
    return np.stack([rows, columns], 2)


def hole():
    """(60, 90) bool, a hole in the middle."""
    mask = np.zeros((60, 90), bool)
    mask[25:35, 40:48] = True
    return mask


def test_what_has_values_keeps_them_and_holes_take_those_around():
    values = ramp()
    filled = spread_colours(np.where(hole()[..., None], 1e3, values).astype(np.float32), 1 - hole().astype(np.float32))
    np.testing.assert_array_equal(filled[~hole()], values[~hole()])
    assert np.abs(filled - values)[hole()].max() < 4


def test_a_box_tells_what_fills_a_hole():
    mask = hole()
    box = box_around(mask)
    assert mask[box].sum() == mask.sum() and not mask[box][0].any() and not mask[box][:, -1].any()
    assert mask[box].size < mask.size / 4
    weights = 1 - mask.astype(np.float32)
    everywhere = spread_colours(ramp(), weights)
    within = spread_colours(ramp()[box], weights[box])
    assert np.abs(everywhere[box] - within).max() < 2


def test_boxes_end_with_the_picture_and_one_of_nothing_is_small():
    corner = np.zeros((9, 9), bool)
    corner[0, 8] = True
    assert corner[box_around(corner)].sum() == 1
    assert ramp()[box_around(np.zeros((60, 90), bool))].shape == (1, 1, 2)
