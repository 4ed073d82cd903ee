import numpy as np
import pytest

from caricli.geometry.polar_quads import polar_quads


@pytest.mark.parametrize(("rows", "columns"), [(1, 3), (4, 7)])
def test_it_is_one_sheet_around_the_pole_with_its_last_ring_for_an_edge(rows, columns):
    quads = polar_quads(rows, columns)
    assert quads.shape == (rows * columns, 4) and quads.dtype == np.int32
    assert (quads[:columns, 0] == 0).all() and (quads[:columns, 3] == -1).all() and quads[columns:].min(initial=1) == 1
    polygons = [polygon[polygon >= 0].tolist() for polygon in quads]
    ways = [way for polygon in polygons for way in zip(polygon, [*polygon[1:], polygon[0]], strict=True)]
    assert len(set(ways)) == len(ways)
    border = {way for way in ways if way[::-1] not in ways}
    last = 1 + (rows - 1) * columns + np.arange(columns)
    assert border == set(zip(last.tolist(), np.roll(last, -1).tolist(), strict=True))
