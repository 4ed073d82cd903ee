import cv2
import numpy as np
import pytest

from caricli.methods.stylise.picture_warp import PictureWarp


@pytest.fixture
def warp():
    """A bulge of the middle of a window, which leaves its borders."""
    rows, columns = np.mgrid[:21, :31] / [[[20]], [[30]]]
    fade = np.sin(np.pi * rows) ** 2 * np.sin(np.pi * columns) ** 2
    grid = np.stack([6 * fade * (0.5 - columns), -5 * fade], -1)
    return PictureWarp.of_grid(np.array([12, 20]), grid, (91, 61))


def test_points_go_where_their_pixels_go(warp):
    generator = np.random.default_rng(0)
    for point in generator.integers([30, 30], [85, 70], (6, 2)):
        image = np.zeros((100, 120, 3), np.uint8)
        image[point[1] - 2 : point[1] + 3, point[0] - 2 : point[0] + 3] = 255
        light = warp.picture(image)[..., 0].astype(float)
        rows, columns = np.indices(light.shape)
        centre = np.array([(columns * light).sum(), (rows * light).sum()]) / light.sum()
        np.testing.assert_allclose(warp.points(point[None].astype(float))[0], centre, atol=0.25)


def test_outside_of_its_window_nothing_moves(warp):
    image = np.random.default_rng(0).integers(0, 256, (100, 120, 3), np.uint8)
    warped = warp.picture(image)
    assert (warped != image).any()
    np.testing.assert_array_equal(warped[:20], image[:20])
    np.testing.assert_array_equal(warped[:, :12], image[:, :12])
    outside = np.array([[3.0, 5.0], [-40.0, 300.0]])
    np.testing.assert_allclose(warp.points(outside), outside, atol=1e-3)


def test_points_that_are_not_known_stay_so(warp):
    points = warp.points(np.array([[50.0, 50.0], [np.nan, np.nan]]))
    assert np.isfinite(points[0]).all() and np.isnan(points[1]).all()


def test_where_pixels_are_many_the_displacement_is_the_same(monkeypatch):
    """Fewer places than pixels, in bands of few rows: what comes out is what all of them give."""
    rows, columns = np.mgrid[:9, :9] / 8
    grid = 4 * np.stack([np.sin(np.pi * rows) * np.sin(np.pi * columns)] * 2, -1)
    image = np.random.default_rng(0).integers(0, 256, (160, 200, 3), np.uint8)
    image = cv2.GaussianBlur(image, (0, 0), 3)
    exact = PictureWarp.of_grid(np.array([0, 0]), grid, (200, 160))
    monkeypatch.setattr("caricli.methods.stylise.picture_warp._FINEST", 60)
    monkeypatch.setattr("caricli.methods.stylise.picture_warp._BAND", 33)
    coarse = PictureWarp.of_grid(np.array([0, 0]), grid, (200, 160))
    assert coarse.moves.shape == (60, 60, 2)
    assert np.abs(coarse.picture(image).astype(int) - exact.picture(image)).max() <= 1
