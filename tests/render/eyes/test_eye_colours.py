import cv2
import numpy as np
import pytest

from caricli.render.eyes.eye_colours import eye_colours

SKIN, WHITE, BLUE, BLACK, LIGHT = (190, 140, 110), (235, 228, 220), (60, 110, 190), (8, 8, 8), (255, 255, 255)
LEFT, RIGHT = (60, 60), (150, 60)


@pytest.fixture
def picture():
    """Two open eyes with iris, pupil and a reflection."""
    image = np.full((120, 210, 3), SKIN, np.uint8)
    for centre in (LEFT, RIGHT):
        cv2.ellipse(image, centre, (30, 13), 0, 0, 360, WHITE, -1)
        cv2.circle(image, centre, 9, BLUE, -1)
        cv2.circle(image, centre, 4, BLACK, -1)
        cv2.circle(image, (centre[0] - 3, centre[1] - 3), 2, LIGHT, -1)
    return image


@pytest.fixture
def points():
    marks = np.random.default_rng(0).uniform(0, 100, (68, 2))
    angles = np.radians([180, 240, 300, 0, 60, 120])
    for k, centre in ((36, LEFT), (42, RIGHT)):
        marks[k : k + 6] = centre + np.stack([30 * np.cos(angles), 13 * np.sin(angles)], axis=1)
    return marks


def test_iris_and_white(picture, points):
    iris, white = eye_colours(picture, points)
    np.testing.assert_allclose(iris, BLUE, atol=12)
    np.testing.assert_allclose(white, WHITE, atol=6)


def test_one_eye_is_enough(picture, points):
    picture[:, 105:] = SKIN
    points[42:48] = np.nan
    iris, white = eye_colours(picture, points)
    np.testing.assert_allclose(iris, BLUE, atol=12)
    np.testing.assert_allclose(white, WHITE, atol=6)


def test_both_eyes_count(picture, points):
    right = picture[:, 105:]
    right[(right == BLUE).all(-1)] = (160, 110, 90)
    iris, _ = eye_colours(picture, points)
    np.testing.assert_allclose(iris, (110, 110, 140), atol=12)


def test_closed_far_and_unknown_eyes_have_no_colours(picture, points):
    closed = points.copy()
    closed[36:48, 1] = 60 + np.tile([0, -0.2, -0.2, 0, 0.2, 0.2], 2)
    closed[36:48, 0] = points[36:48, 0] / 10
    for marks in (closed, points + 1000, np.full((68, 2), np.nan)):
        assert eye_colours(picture, marks) == (None, None)


def test_an_eye_that_hair_covers_hardly_counts(picture, points):
    picture[:, 105:] = (70, 45, 30)
    iris, white = eye_colours(picture, points)
    np.testing.assert_allclose(iris, BLUE, atol=12)
    np.testing.assert_allclose(white, WHITE, atol=6)


def test_an_iris_that_looks_aside_is_found(picture, points):
    for centre in (LEFT, RIGHT):
        cv2.ellipse(picture, centre, (30, 13), 0, 0, 360, WHITE, -1)
        cv2.circle(picture, (centre[0] + 14, centre[1]), 9, BLUE, -1)
    iris, white = eye_colours(picture, points)
    np.testing.assert_allclose(iris, BLUE, atol=12)
    np.testing.assert_allclose(white, WHITE, atol=6)
