import numpy as np

from caricli.render.sheets.picture_sheet import HIDDEN, SEEN, explained, picture_sheet
from caricli.structures.parsing import REGION_COLOURS, Region

IMAGE = np.full((40, 60, 3), 100, np.uint8)
REGIONS = np.zeros((40, 60), np.uint8)
REGIONS[:, 30:] = Region.SKIN
POINTS = np.array([[10.2, 30.0], [50.0, 8.4]])


def test_regions_lie_over_the_picture_and_nothing_does_where_there_is_none():
    drawn = explained(IMAGE, REGIONS, POINTS[:0], np.zeros(0, bool))
    assert (drawn[:, :30] == 100).all()
    toward = np.array(REGION_COLOURS[Region.SKIN], float) - 100
    share = (drawn[20, 45] - 100.0)[toward != 0] / toward[toward != 0]
    assert ((share > 0.4) & (share < 0.9)).all()
    assert (IMAGE == 100).all()


def test_landmarks_are_where_they_are_in_the_colour_of_what_is_seen_of_them():
    drawn = explained(IMAGE, 0 * REGIONS, POINTS, np.array([True, False]))
    assert drawn[30, 10].tolist() == [*SEEN] and drawn[8, 50].tolist() == [*HIDDEN]
    assert (drawn != 100).any(2).sum() < 40


def test_every_picture_is_beside_its_truth():
    other = np.full_like(IMAGE, 200)
    visible = np.ones(2, bool)
    sheet = picture_sheet([(IMAGE, REGIONS, POINTS, visible), (other, REGIONS, POINTS, visible)]).astype(int)
    places = [np.argwhere((sheet == grey).all(2)).mean(0) for grey in (100, 200)]
    assert places[1].sum() > places[0].sum() + 20
    for grey in (100, 200):
        rows, columns = np.nonzero((sheet == grey).all(2))
        # Three quarters of the two: the picture, and of the other one what no region covers.
        assert np.ptp(columns) + 1 == 90 and np.ptp(rows) + 1 == 40
