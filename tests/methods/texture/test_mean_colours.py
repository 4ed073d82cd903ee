import cv2
import numpy as np
import pytest

from caricli.methods.texture.mean_colours import mean_colours

RED = (200, 40, 30)
BLUE = (20, 60, 220)


def lab(colour):
    return cv2.cvtColor(np.array([[colour]], np.float32) / 255, cv2.COLOR_RGB2LAB)[0, 0]


def halves(width=200):
    """Red on the left, blue on the right, and where it is red."""
    red = np.broadcast_to(np.arange(width) < 0.43 * width, (width, width))
    return np.where(red[..., None], RED, BLUE).astype(np.uint8), red


@pytest.mark.parametrize("reach", [2, 6, 20, 29])
def test_what_is_beside_the_mask_colours_no_mean(reach):
    image, red = halves()
    means = mean_colours(image, red, reach)
    there = np.isfinite(means).all(2)
    assert there[red].all() and not there[:, -1].any()
    assert np.abs(means[there] - lab(RED)).max() < 0.05


@pytest.mark.parametrize("reach", [0.7, 2, 4, 6, 20])
def test_means_are_those_of_a_gaussian_of_that_reach(reach):
    """Across the border of two colours of which both count they are as far apart as the Gaussian's integral says."""
    image, red = halves()
    means = mean_colours(image, np.ones_like(red), reach)
    share = cv2.GaussianBlur(red.astype(np.float32), (0, 0), reach)
    np.testing.assert_allclose(means, share[..., None] * lab(RED) + (1 - share[..., None]) * lab(BLUE), atol=8)


@pytest.mark.parametrize("shape", [(200, 3), (3, 200), (1, 1), (2, 2)])
def test_a_narrow_picture_has_means_too(shape):
    image = np.full((*shape, 3), RED, np.uint8)
    means = mean_colours(image, np.ones(shape, bool), 40)
    np.testing.assert_allclose(means, np.broadcast_to(lab(RED), image.shape), rtol=1e-4)


def test_none_of_it_has_no_mean_and_no_reach_is_a_small_one():
    image, red = halves(40)
    assert np.isnan(mean_colours(image, np.zeros_like(red), 5)).all()
    means = mean_colours(image, red, 0)
    assert np.abs(means[red] - lab(RED)).max() < 0.05 and np.isnan(means[:, -10:]).all()
