import numpy as np

from caricli.render.sheets.view_sheets import film_strip, view_rows


def views(*greys):
    return [np.full((40, 30, 3), grey, np.uint8) for grey in greys]


def test_heads_stand_beside_or_below_each_other():
    heads, labels = [views(10, 60), views(110, 160), views(210, 240)], ["a", "b", "c"]
    strip, rows = film_strip(heads, labels), view_rows(heads, labels)
    assert strip.shape[1] > 3 * 30 and 2 * 40 < strip.shape[0] < 3 * 40
    assert rows.shape[0] > 3 * 40 and 2 * 30 < rows.shape[1] < 3 * 30
    for sheet, axis in ((strip, 1), (rows, 0)):
        places = [np.argwhere((sheet == grey).all(-1)).mean(0)[axis] for grey in (10, 110, 210)]
        assert places == sorted(places)
