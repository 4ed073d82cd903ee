"""rows_at."""

import numpy as np

from caricli.geometry.lines.rows_at import rows_at


def test_rows_are_linear_between_places_and_stay_beyond_them():
    rows = np.array([[0.0, 10.0, 1.0], [2.0, 0.0, 1.0], [2.0, 8.0, 1.0]])
    read = rows_at(np.array([-1.0, 0.25, 1.0, 2.0, 9.0]), np.array([0.0, 1.0, 3.0]), rows)
    assert read.tolist() == [[0, 10, 1], [0.5, 7.5, 1], [2, 0, 1], [2, 4, 1], [2, 8, 1]]
