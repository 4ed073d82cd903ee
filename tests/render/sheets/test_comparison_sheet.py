import numpy as np

from caricli.render.sheets.comparison_sheet import comparison_sheet

SIZE = 64


def rows(sheet):
    height = sheet.shape[0] // 3
    return [sheet[k * height : (k + 1) * height].astype(int) for k in range(3)]


def red(picture):
    """Pixels in which red stands out far above green and blue."""
    return (picture[..., 0] > 1.8 * np.maximum(picture[..., 1], picture[..., 2]) + 20).sum()


def test_equal_heads_have_no_red_and_three_rows_of_three_views(lopsided_head):
    sheet = comparison_sheet(lopsided_head, lopsided_head, SIZE)
    assert sheet.shape[0] > 3 * SIZE and sheet.shape[1] > 3 * SIZE
    assert all((row < 205).any(-1).mean() > 0.2 for row in rows(sheet))
    assert red(rows(sheet)[2]) == 0


def test_red_is_where_the_heads_differ(lopsided_head):
    vertices = lopsided_head.vertices
    found = vertices.copy()
    found[vertices[:, 1] > 0.3] *= 1.1
    given, encoded, distance = rows(comparison_sheet(lopsided_head, lopsided_head.with_vertices(found), SIZE))
    assert red(given) == red(encoded) == 0
    height = len(distance) // 2
    assert red(distance[:height]) > 100 > 10 * red(distance[height:])
