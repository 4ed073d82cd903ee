import numpy as np
import pytest

from caricli.geometry.lines.mark_lines import mark_lines
from caricli.geometry.lines.slide_points import line_shares
from tests.drawn_pictures import mean_shape

LINES = {"brow": range(17, 22), "bridge": range(27, 31), "upper lip": range(48, 55), "lower lip": (*range(54, 60), 48)}
STAY = [*range(17), 17, 21, 22, 26, 27, 30, 31, 35, *range(36, 48), 48, 54, 60, 64, *range(68, 81)]


@pytest.mark.parametrize(
    ("line", "shares"),
    [
        ("brow", (0, 0.23, 0.48, 0.74, 1)),
        ("bridge", (0, 0.33, 0.67, 1)),
        ("upper lip", (0, 0.19, 0.37, 0.5, 0.63, 0.81, 1)),
        ("lower lip", (0, 0.21, 0.38, 0.5, 0.62, 0.79, 1)),
    ],
)
def test_inner_points_of_lines_go_to_where_people_mark_them(head_template, line, shares):
    shape = mean_shape(head_template)
    numbers = list(LINES[line])
    assert np.abs(line_shares(shape[numbers]) - shares).max() > 0.02
    assert np.abs(line_shares(mark_lines(shape)[numbers]) - shares).max() < 0.02


def test_everything_else_and_lines_that_are_not_known_stay(head_template):
    shape = mean_shape(head_template)
    np.testing.assert_allclose(mark_lines(shape)[STAY], shape[STAY], atol=1e-12)
    part = shape.copy()
    part[19] = np.nan
    marked = mark_lines(part)
    np.testing.assert_array_equal(marked[17:22], part[17:22])
    np.testing.assert_allclose(marked[22:], mark_lines(shape)[22:], atol=1e-12)
