import numpy as np
import pytest

from caricli.render.sheets.landmark_pair import COLOURS, landmark_pair


def test_two_sets_side_by_side_at_one_scale():
    points = np.random.default_rng(0).uniform(0, 100, (68, 2))
    sheet = landmark_pair({"caricature": points, "normal": 0.5 * points}, 96)
    assert sheet.shape[1] > 2 * 96 and sheet.shape[0] < 2 * 96
    columns, widths = [], []
    for colour in COLOURS.values():
        places = np.argwhere((sheet == colour).all(-1))
        columns.append(places[:, 1].mean())
        widths.append(np.ptp(places[:, 1]))
    assert columns[1] < columns[0], "the given caricature is on the left"
    assert widths[0] < 0.65 * widths[1]


def test_labels_say_which_were_given(monkeypatch):
    told = []
    monkeypatch.setattr(
        "caricli.render.sheets.landmark_pair.contact_sheet", lambda pictures, columns, labels: told.append(labels)
    )
    points = np.random.default_rng(0).uniform(0, 100, (68, 2))
    landmark_pair({"caricature": points, "normal": points}, 48)
    landmark_pair({"normal": points, "caricature": points}, 48)
    assert told == [["caricature, given", "normal, mapped"], ["normal, given", "caricature, mapped"]]


def test_all_of_a_long_face_is_in_its_drawing():
    points = np.random.default_rng(0).uniform(0, 100, (68, 2)) * [0.3, 1]
    sheet = landmark_pair({"caricature": points, "normal": points}, 96)
    for colour in COLOURS.values():
        assert np.ptp(np.argwhere((sheet == colour).all(-1))[:, 0]) == pytest.approx(0.7 * 96, abs=6)
