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


def test_labels_say_from_where_on_it_is_as_red_as_it_gets(lopsided_head, monkeypatch):
    told = {}

    def contact_sheet(rows, columns, labels):
        told["labels"] = labels
        return np.vstack(rows)

    monkeypatch.setattr("caricli.render.sheets.comparison_sheet.contact_sheet", contact_sheet)
    height = np.ptp(lopsided_head.vertices[:, 1])
    reds = []
    for share in (0.01, 0.02, 0.04):
        other = lopsided_head.with_vertices(lopsided_head.vertices + [0, 0, share * height])
        distance = comparison_sheet(lopsided_head, other, SIZE)[2 * SIZE :].astype(int)
        reds.append(np.percentile(distance[..., 0] - distance[..., 1], 90))
    assert told["labels"] == ["given", "encoded", f"distance, red from {20 * height:.1f} mm"]
    assert reds[0] < 0.8 * reds[1] and reds[1] == reds[2]
