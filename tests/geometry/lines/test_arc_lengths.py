import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths


def test_lengths_are_sums_of_steps():
    corner = np.array([[0.0, 0, 0], [3, 0, 4], [3, 2, 4], [3, 2, 4]])
    assert arc_lengths(corner).tolist() == [0, 5, 7, 7]
    assert arc_lengths(corner[::-1]).tolist() == [0, 0, 2, 7]
    assert arc_lengths(corner[:1]).tolist() == [0]
