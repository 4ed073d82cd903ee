import numpy as np

from caricli.render.sheets import stylise_sheet as sheet


def test_pictures_follow_one_another_and_the_last_has_its_landmarks(monkeypatch):
    told = {}

    def contact_sheet(faces, columns, labels):
        told.update(faces=faces, columns=columns, labels=labels)
        return faces[0]

    monkeypatch.setattr(sheet, "contact_sheet", contact_sheet)
    pictures = {name: np.full((200, 200, 3), grey, np.uint8) for name, grey in (("given", 40), ("painted", 160))}
    landmarks = np.array([[60.0, 60], [140, 60], [100, 140], [np.nan, np.nan]])
    sheet.stylise_sheet(pictures, landmarks)
    assert told["labels"] == ["given", "painted", "landmarks"] and told["columns"] == 3
    given, painted, marked = (face.astype(int) for face in told["faces"])
    assert np.ptp(given) == 0 and given[0, 0, 0] == 40 and np.ptp(painted) == 0 and painted[0, 0, 0] == 160
    dots = np.abs(marked - sheet.MOVED).max(2) < 20
    assert 3 * 20 < dots.sum() < 3 * 1000 and (marked[~dots] > 120).mean() > 0.99
    # The eyes are above the mouth, at half and at both sides of the width.
    rows, columns = np.nonzero(dots)
    assert np.median(rows) < 240 and abs(columns.mean() - 240) < 12
