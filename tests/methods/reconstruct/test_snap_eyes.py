import cv2
import numpy as np
import pytest

from caricli.methods.reconstruct.settings import SnapSettings
from caricli.methods.reconstruct.snap_eyes import snap_eyes

FARTHEST = SnapSettings().farthest

LEFT, RIGHT = np.array([60.0, 80.0]), np.array([150.0, 80.0])
RADII = 20, 10


@pytest.fixture
def parsing():
    """Two ellipses of labels 4 and 5 in a picture of skin, 1."""
    labels = np.ones((160, 220), np.uint8)
    for number, centre in ((4, LEFT), (5, RIGHT)):
        cv2.ellipse(labels, centre.astype(int).tolist(), RADII, 0, 0, 360, number, -1)
    return labels


def marks(factor):
    """68 points, the eyes' on the ellipses, larger by a factor."""
    points = np.random.default_rng(0).uniform(0, 150, (68, 2))
    angles = np.radians([180, 240, 300, 0, 60, 120])
    around = factor * np.stack([RADII[0] * np.cos(angles), RADII[1] * np.sin(angles)], axis=1)
    points[36:42], points[42:48] = LEFT + around, RIGHT + around
    return points


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_eyes_land_on_the_border_and_nothing_else_moves(parsing, factor):
    points = marks(factor)
    given = points.copy()
    snapped, moved = snap_eyes(points, np.isin(parsing, [4, 5]))
    np.testing.assert_array_equal(points, given)
    assert moved == 12
    for k in range(36, 48):
        x, y = np.round(snapped[k]).astype(int)
        beside = parsing[y - 1 : y + 2, x - 1 : x + 2]
        assert parsing[y, x] == (4 if k < 42 else 5) and (beside == 1).any()
        # The nearest place of the border, by trying all of them.
        cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
        border = np.argwhere((parsing > 1) & (cv2.erode(parsing, cross) == 1))[:, ::-1]
        nearest = np.linalg.norm(border - points[k], axis=1).min()
        assert np.linalg.norm(snapped[k] - points[k]) == pytest.approx(nearest, abs=1e-9)
    others = np.r_[0:36, 48:68]
    np.testing.assert_array_equal(snapped[others], points[others])


def test_landmarks_of_an_eye_stay_apart_where_it_is_seen_half_closed(parsing):
    shut = np.isin(parsing, [4, 5])
    shut[: int(LEFT[1]) - 1] = shut[int(LEFT[1]) + 1 :] = False
    shut[:, : int(LEFT[0]) - 8] = shut[:, int(RIGHT[0]) + 8 :] = False
    snapped, moved = snap_eyes(marks(1.0), shut)
    assert 4 < moved < 12
    for eye in (snapped[36:42], snapped[42:48]):
        assert len(np.unique(eye, axis=0)) == 6


def test_no_landmark_goes_further_than_half_its_eye(parsing):
    points = marks(1.0)
    width = np.linalg.norm(np.ptp(points[36:42], axis=0))
    # Down, away from both eyes.
    for share, expected in ((0.9, 12), (1.5, 0)):
        moved_down = points.copy()
        moved_down[36:48, 1] += share * FARTHEST * width + RADII[1] * (share > 1)
        snapped, count = snap_eyes(moved_down, np.isin(parsing, [4, 5]))
        assert count == expected
        assert np.linalg.norm(snapped - moved_down, axis=1).max() <= FARTHEST * width + 1e-9


def test_unknown_landmarks_and_absent_labels(parsing):
    points = marks(1.1)
    points[[36, 43]] = np.nan
    snapped, moved = snap_eyes(points, np.isin(parsing, [4, 5]))
    assert moved == 10 and np.isnan(snapped[[36, 43]]).all()
    snapped, moved = snap_eyes(points, np.isin(parsing, [7]))
    assert moved == 0
    np.testing.assert_array_equal(snapped, points)
    # An eye that is not parsed stays, if the other one is far.
    snapped, moved = snap_eyes(points, np.isin(parsing, [4]))
    assert moved == 5
    np.testing.assert_array_equal(snapped[42:48], points[42:48])
