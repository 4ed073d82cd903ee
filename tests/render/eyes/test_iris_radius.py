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
