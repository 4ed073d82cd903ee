import numpy as np
import pytest

from caricli.render.eyes.eye_window import WIDTH, eye_windows


@pytest.fixture
def face():
    """A picture whose red says the column and whose green the row, and landmarks of two eyes in it."""
    rows, columns = np.mgrid[:120, :200]
    points = np.full((68, 2), np.nan)
    ring = np.array([[-15, 0], [-7, -6], [7, -6], [15, 0], [7, 6], [-7, 6]], float)
    points[36:42] = ring + [60, 50]
    points[42:48] = 0.8 * ring + [140, 70]
    return np.stack([columns, rows, 0 * rows], -1).astype(np.uint8), points


def test_eyes_are_in_the_middle_of_their_windows_the_right_one_first(face):
    image, points = face
    right, left = eye_windows(image, points, 2.0)
    for window, middle, width in ((right, (60, 50), 30), (left, (140, 70), 24)):
        side = len(window.picture)
        assert window.picture.shape == (2 * WIDTH, 2 * WIDTH, 3) and window.zoom == pytest.approx(WIDTH / width)
        assert np.ptp(window.outline[:, 0]) == pytest.approx(WIDTH)
        np.testing.assert_allclose(window.outline.mean(0), side / 2)
        assert np.abs(window.picture[side // 2, side // 2, :2].astype(int) - middle).max() <= 1


def test_eyes_that_are_not_known_or_beside_the_picture_have_none(face):
    image, points = face
    unknown = points.copy()
    unknown[37] = np.nan
    assert len(list(eye_windows(image, unknown, 2.0))) == 1
    for shift in ([100, 0], [-70, 0], [0, 60], [0, -60]):
        assert len(list(eye_windows(image, points + shift, 2.0))) == 1
    assert list(eye_windows(image, points + 500, 2.0)) == []


@pytest.mark.parametrize("degrees", [20, 45, 90])
def test_a_tilted_eye_is_as_wide_as_an_upright_one(face, degrees):
    image, points = face
    turn = np.array([[np.cos(a := np.radians(degrees)), np.sin(a)], [-np.sin(a), np.cos(a)]])
    middle = points[36:42].mean(0)
    upright = next(eye_windows(image, points, 2.0))
    tilted = next(eye_windows(image, (points - middle) @ turn + middle, 2.0))
    assert tilted.zoom == pytest.approx(upright.zoom)
