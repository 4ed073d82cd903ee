import cv2
import numpy as np
import pytest

from caricli.render.eyes.iris_radius import iris_radius

MIDDLES = ((60, 60), (150, 60))


def eyes(radius, aside=0, iris=(60, 110, 190)):
    """Two open eyes, 60 pixels wide, and landmarks of their lids."""
    image = np.full((120, 210, 3), (190, 140, 110), np.uint8)
    marks = np.random.default_rng(0).uniform(0, 100, (68, 2))
    angles = np.radians([180, 240, 300, 0, 60, 120])
    for first, (x, y) in zip((36, 42), MIDDLES, strict=True):
        opening = np.zeros(image.shape[:2], np.uint8)
        cv2.ellipse(opening, (x, y), (30, 13), 0, 0, 360, 1, -1)
        eye = np.full_like(image, (235, 228, 220))
        cv2.circle(eye, (x + aside, y), radius, iris, -1)
        image[opening > 0] = eye[opening > 0]
        marks[first : first + 6] = np.array([x, y]) + np.stack([30 * np.cos(angles), 13 * np.sin(angles)], axis=1)
    return image, marks


@pytest.mark.parametrize("aside", [0, 9])
@pytest.mark.parametrize("radius", [8, 12, 18])
def test_the_radius_of_both_irises(radius, aside):
    pixels, explained = iris_radius(*eyes(radius, aside))
    assert abs(pixels - radius) < 0.15 * radius and explained > 0.75


def test_what_is_no_disc_explains_little():
    image, marks = eyes(10)
    noise = np.random.default_rng(1).integers(60, 200, (*image.shape[:2], 1))
    assert iris_radius(np.broadcast_to(noise, image.shape).astype(np.uint8), marks)[1] < 0.3


def test_one_eye_alone_says_nothing():
    image, marks = eyes(10)
    marks[36:42] = np.nan
    assert iris_radius(image, marks) == (0, 0)
    plain = np.full_like(image, 128)
    assert iris_radius(plain, eyes(10)[1])[1] == 0


@pytest.mark.parametrize("colour", [(255, 255, 255), (90, 50, 20)])
def test_eyes_of_one_colour_have_no_iris(colour):
    image, marks = eyes(10)
    image[:] = colour
    assert iris_radius(image, marks) == (0, 0)


@pytest.mark.parametrize("times", [0.5, 3])
def test_the_radius_is_in_pixels_of_the_picture(times):
    image, marks = eyes(12)
    larger = cv2.resize(image, None, fx=times, fy=times, interpolation=cv2.INTER_AREA)
    pixels, explained = iris_radius(larger, (marks + 0.5) * times - 0.5)
    assert abs(pixels - 12 * times) < 0.15 * 12 * times and explained > 0.75


def test_irises_are_of_one_size_where_eyes_are_not():
    """As of a head that is turned: the lids of one eye are less far apart, the iris is as large."""
    image, marks = eyes(11)
    narrow = image[:, 120:180]
    image[:, 120:180] = np.where(np.abs(np.arange(60) - 30)[:, None] < 15, narrow, (190, 140, 110))
    marks[42:48, 0] = 150 + (marks[42:48, 0] - 150) / 2
    pixels, explained = iris_radius(image, marks)
    assert abs(pixels - 11) < 1.7 and explained > 0.6


def test_a_disc_that_is_lighter_is_no_iris():
    image, marks = eyes(10, iris=(255, 255, 255))
    dark = np.where((image == (235, 228, 220)).all(-1, keepdims=True), (70, 60, 50), image).astype(np.uint8)
    assert iris_radius(dark, marks)[1] < 0.3


def test_a_blue_iris_is_told_by_what_it_lacks():
    pixels, explained = iris_radius(*eyes(12, iris=(60, 110, 235)))
    assert abs(pixels - 12) < 0.15 * 12 and explained > 0.75
