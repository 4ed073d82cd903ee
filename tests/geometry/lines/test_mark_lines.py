import numpy as np
import pytest

from caricli.geometry.lines.mark_lines import mark_lines
from caricli.geometry.lines.slide_points import line_shares
from tests.drawn_pictures import mean_shape

LINES = {
    "right brow": range(17, 22),
    "left brow": range(22, 27),
    "bridge": range(27, 31),
    "nostrils": range(31, 36),
    "upper lip": range(48, 55),
    "lower lip": (*range(54, 60), 48),
    "upper lip's inside": range(60, 65),
    "lower lip's inside": (*range(64, 68), 60),
}
STAY = [*range(17), 17, 21, 22, 26, 27, 30, 31, 35, *range(36, 48), 48, 54, 60, 64, *range(68, 81)]


@pytest.mark.parametrize(
    ("line", "shares"),
    [
        ("right brow", (0, 0.23, 0.48, 0.74, 1)),
        ("left brow", (0, 0.26, 0.52, 0.77, 1)),
        ("bridge", (0, 0.33, 0.67, 1)),
        ("upper lip", (0, 0.19, 0.37, 0.5, 0.63, 0.81, 1)),
        ("nostrils", (0, 0.25, 0.5, 0.75, 1)),
        ("lower lip", (0, 0.21, 0.38, 0.5, 0.62, 0.79, 1)),
        ("upper lip's inside", (0, 0.34, 0.5, 0.66, 1)),
        ("lower lip's inside", (0, 0.34, 0.5, 0.66, 1)),
    ],
)
def test_inner_points_of_lines_go_to_where_people_mark_them(head_template, line, shares):
    shape = mean_shape(head_template)
    numbers = list(LINES[line])
    before = shape.copy()
    # Where marks stand as people set them they are moved along their lines, to the left and to the right.
    shape[numbers[1:-1]] += 0.1 * (shape[numbers[2:]] - shape[numbers[1:-1]])
    marked = mark_lines(shape)
    assert np.abs(line_shares(marked[numbers]) - shares).max() < 0.015
    assert np.abs(line_shares(shape[numbers]) - shares).max() > 0.02
    others = np.delete(before, numbers, axis=0)
    np.testing.assert_array_equal(np.delete(shape, numbers, axis=0), others)


def test_everything_else_and_lines_that_are_not_known_stay(head_template):
    shape = mean_shape(head_template)
    np.testing.assert_allclose(mark_lines(shape)[STAY], shape[STAY], atol=1e-12)
    part = shape.copy()
    part[19] = np.nan
    marked = mark_lines(part)
    np.testing.assert_array_equal(marked[17:22], part[17:22])
    np.testing.assert_allclose(marked[22:], mark_lines(shape)[22:], atol=1e-12)
