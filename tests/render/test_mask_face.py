import numpy as np
import pytest

from caricli.render.mask_face import mask_face
from caricli.render.rasterise import rasterise
from caricli.structures.landmarks import OUTLINE

HEIGHT, WIDTH = 240, 220
CENTRE, RADII = np.array([110.0, 120.0]), np.array([70.0, 95.0])
SKIN, PAPER = (205, 150, 120), (60, 110, 170)


def grid(shape):
    y, x = np.mgrid[: shape[0], : shape[1]]
    return x, y


def ellipse(shape, centre=CENTRE, radii=RADII):
    x, y = grid(shape)
    return ((x - centre[0]) / radii[0]) ** 2 + ((y - centre[1]) / radii[1]) ** 2 < 1


@pytest.fixture
def points():
    """Jaw and brows of a face in the ellipse; nothing else is known."""
    marks = np.full((68, 2), np.nan)
    angles = np.radians(np.linspace(170, 10, 17))
    marks[:17] = CENTRE + RADII * 0.92 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    marks[17:27] = CENTRE + np.stack([np.linspace(-50, 50, 10), np.full(10, -35.0)], axis=1)
    return marks


@pytest.fixture
def projected(sphere):
    """A fitted mesh that is narrower than the head."""
    vertices, faces = sphere
    return vertices * [*(0.85 * RADII), 50] * [1, -1, -1] + [*CENTRE, 0], faces


def picture(noise=8):
    image = np.where(ellipse((HEIGHT, WIDTH))[..., None], SKIN, PAPER)
    image = image + np.random.default_rng(0).normal(0, noise, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def overlap(first, second):
    return (first & second).sum() / (first | second).sum()


def test_a_head_is_found_by_its_colours(points, projected):
    image = picture()
    mask = mask_face(image, *projected, points)
    truth = ellipse(image.shape)
    assert mask.shape == (HEIGHT, WIDTH) and mask.dtype == bool
    assert overlap(mask, truth) > 0.9
    # It is the colours that say so: mesh and landmarks alone are further away.
    assert overlap(rasterise(projected[0], projected[1], WIDTH, HEIGHT).face >= 0, truth) < 0.85


def test_large_pictures_are_cut_alike(points, projected):
    large = np.repeat(np.repeat(picture(), 4, axis=0), 4, axis=1)
    mask = mask_face(large, 4 * projected[0] + [1.5, 1.5, 0], projected[1], 4 * points + 1.5)
    assert mask.shape == large.shape[:2]
    assert overlap(mask, ellipse(large.shape, 4 * CENTRE + 1.5, 4 * RADII)) > 0.9


def test_something_else_of_the_same_colour_is_left_out(points, projected):
    image = picture()
    image[200:235, 185:215] = SKIN
    mask = mask_face(image, *projected, points)
    assert not mask[205:, 190:].any() and overlap(mask, ellipse(image.shape)) > 0.9


def test_where_colours_tell_nothing_the_landmarks_do(points, projected):
    mask = mask_face(np.full((HEIGHT, WIDTH, 3), 120, np.uint8), *projected, points)
    middle = points[list(OUTLINE)].mean(0).round().astype(int)
    assert mask[middle[1], middle[0]] and 0.1 < mask.mean() < 0.7
    assert not mask[:10].any() and not mask[:, :5].any()


def test_a_face_that_fills_its_picture(points, projected):
    mask = mask_face(picture()[60:180, 60:160], projected[0] - [60, 60, 0], projected[1], points - 60)
    assert mask.mean() > 0.8


def test_it_is_the_same_every_time_and_changes_nothing(points, projected):
    image = picture(25)
    before, marks = image.copy(), points.copy()
    first, again = (mask_face(image, *projected, points) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(image, before)
    np.testing.assert_array_equal(points, marks)
