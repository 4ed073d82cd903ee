import cv2
import numpy as np
import pytest

from caricli.methods.redraw.moved_head import MovedHead
from caricli.methods.redraw.openings import seams
from caricli.methods.redraw.redraw_picture import redraw_picture
from tests.methods.redraw.conftest import CAMERA

WIDE = {"jawOpen": 0.7}
SEAM = {"jawOpen": 0.7, "mouthClose": 0.68}


@pytest.fixture(scope="module")
def laughing(stage):
    """An Original whose mouth is open and full of white teeth."""
    shape = stage.shape(**WIDE)
    picture = stage.picture(shape)
    inner = cv2.erode(stage.mouth(shape).astype(np.uint8), np.ones((3, 3))) > 0
    picture[inner] = 255
    return stage.original(shape, picture=picture)


def test_a_mouth_that_closes_to_a_line_shows_no_drawn_teeth(stage, laughing):
    shape = stage.shape(**SEAM)
    head = MovedHead(laughing, shape)
    assert laughing.rows is not None and head.view.inside.sum() > 10
    assert head.seam[head.view.inside].min() > 0.9 and not head.seam[~head.view.inside].any()
    again = redraw_picture(laughing, shape).astype(float)
    mouth = stage.mouth(shape)
    around = (cv2.dilate(mouth.astype(np.uint8), np.ones((7, 7))) > 0) & ~mouth
    assert again[mouth].max() < 1.1 * again[around].max()
    assert again[mouth].mean() < again[around].mean()


def test_an_open_mouth_and_one_that_was_drawn_as_a_line_are_no_seams(stage, laughing):
    assert not seams(laughing, laughing.view).any()
    shape = stage.shape(**SEAM)
    thin = stage.original(shape)
    assert not seams(thin, thin.view).any()
    np.testing.assert_array_equal(redraw_picture(thin, shape), thin.picture)


def test_the_size_of_a_seam_goes_by_the_mouth(stage, laughing):
    """An open mouth is no line however small its picture is."""
    placed = CAMERA.place(stage.shape(**WIDE)) * [0.4, 0.4, 1]
    assert not seams(laughing, laughing.see(placed + [60, 60, 0])).any()
