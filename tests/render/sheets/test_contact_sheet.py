import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.backdrop import PAPER, backdrop
from caricli.render.pixels.blend import over
from caricli.render.sheets.contact_sheet import contact_sheet, legible


def plain(colour, height=40, width=40):
    return np.full((height, width, 3), colour, np.uint8)


def test_pictures_stand_in_rows_and_columns():
    colours = [(250, 0, 0), (0, 250, 0), (0, 0, 250), (250, 250, 0), (0, 250, 250)]
    sheet = contact_sheet([plain(c) for c in colours], columns=3)
    gap = (sheet.shape[1] - 120) // 4
    assert sheet.shape == (2 * 40 + 3 * gap, 3 * 40 + 4 * gap, 3) and sheet.dtype == np.uint8
    for k, colour in enumerate(colours):
        top, left = gap + (k // 3) * (40 + gap), gap + (k % 3) * (40 + gap)
        assert (sheet[top : top + 40, left : left + 40] == colour).all()
    assert (sheet[-40 - gap :, -40 - gap :] == PAPER).all()
    assert (sheet == PAPER).all(-1).sum() == sheet.shape[0] * sheet.shape[1] - 5 * 40 * 40


def test_alpha_lets_the_backdrop_through_and_small_pictures_are_centred():
    clear = np.zeros((20, 20, 4), np.uint8)
    half = np.full((40, 40, 4), 128, np.uint8)
    sheet = contact_sheet([half, clear], columns=2)
    gap = (sheet.shape[1] - 80) // 3
    np.testing.assert_array_equal(sheet[gap : gap + 40, gap : gap + 40], over(half, backdrop(40, 40)))
    np.testing.assert_array_equal(sheet[gap + 10 : gap + 30, 2 * gap + 50 : 2 * gap + 70], backdrop(20, 20))
    small = contact_sheet([plain(0), plain(250, 20, 10)], columns=2)
    y, x = np.nonzero((small == 250).all(-1))
    gap = (small.shape[1] - 80) // 3
    assert (y.min() - gap, x.min() - 2 * gap - 40) == (10, 15) and len(y) == 200


def test_columns_follow_the_shape_of_the_pictures():
    assert np.ptp(contact_sheet([plain(0)] * 9).shape[:2]) == 0
    wide = contact_sheet([plain(0, 20, 80)] * 4)
    assert wide.shape[0] > wide.shape[1]


def test_labels_are_written_below_and_shortened():
    bare, labelled = (contact_sheet([plain(250)] * 2, 2, labels=labels) for labels in (None, ["", "a name"]))
    assert labelled.shape[0] > bare.shape[0] and labelled.shape[1] == bare.shape[1]
    dark = np.argwhere(labelled.min(-1) < 200)
    assert len(dark) > 10 and dark[:, 0].min() > 40 and dark[:, 1].min() > 42
    for text in ("long" * 30, "two\nlines\x00"):
        sheet = contact_sheet([plain(250)], labels=[text])
        x = np.argwhere(sheet.min(-1) < 200)[:, 1]
        assert 1 < x.min() and x.max() < sheet.shape[1] - 2


def test_labels_have_the_letters_of_english():
    assert legible("größe kopf é – Ærø") == "grosse kopf e - Aero"
    assert legible("жук\n1") == "????1"


def test_nothing_and_mismatched_labels_are_refused():
    with pytest.raises(InputError, match="at least one"):
        contact_sheet([])
    with pytest.raises(InputError, match="2 pictures.*1"):
        contact_sheet([plain(0)] * 2, labels=["one"])
