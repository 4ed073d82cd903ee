import numpy as np
import pytest

from caricli.methods.sketch.names_in_order import names_in_order


def line(y, start=0.0, end=40.0):
    return np.column_stack([np.linspace(start, end, 9), np.full(9, float(y))])


def test_lines_that_lie_as_their_names_say_keep_them():
    lines = {"brow_left": line(10), "eye_upper_left": line(20), "eye_lower_left": line(26), "nose": line(0)}
    assert names_in_order(lines, 2.0) == {name: name for name in lines}


@pytest.mark.parametrize("turn", [1, -1])
def test_a_brow_below_both_lids_is_a_lid(turn):
    """Whichever way strokes were drawn."""
    lines = {"brow_left": line(26)[::turn], "eye_upper_left": line(10)[::turn], "eye_lower_left": line(20)}
    right = {"brow_left": "eye_lower_left", "eye_upper_left": "brow_left", "eye_lower_left": "eye_upper_left"}
    assert names_in_order(lines, 2.0) == right


def test_lips_that_hardly_cross_keep_their_names():
    lines = {"mouth_inner_upper": line(31), "mouth_inner_lower": line(30), "mouth_lower": line(20)}
    right = {"mouth_inner_upper": "mouth_lower", "mouth_lower": "mouth_inner_upper"}
    assert names_in_order(lines, 0.0) == right | {"mouth_inner_lower": "mouth_inner_lower"}
    assert names_in_order({key: lines[key] for key in list(lines)[:2]}, 2.0)["mouth_inner_upper"] == "mouth_inner_upper"


def test_lines_beside_each_other_are_compared_as_wholes():
    lines = {"mouth_upper": line(50, 0, 10), "mouth_lower": line(20, 30, 40)}
    assert names_in_order(lines, 2.0) == {"mouth_upper": "mouth_lower", "mouth_lower": "mouth_upper"}


def test_names_of_other_curves_stay():
    assert names_in_order({"nose": line(50), "silhouette": line(0)}, 2.0) == {
        "nose": "nose",
        "silhouette": "silhouette",
    }
    assert names_in_order({}, 2.0) == {}
