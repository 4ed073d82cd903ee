from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.texture.mask_head import mask_head, mesh_pixels
from caricli.structures import Camera, Face, Mesh
from caricli.structures.landmarks import OUTLINE

HEIGHT, WIDTH = 240, 220
CENTRE, RADII = np.array([110.0, 120.0]), np.array([70.0, 95.0])
SKIN, PAPER = (205, 150, 120), (60, 110, 170)


def moved(face, shift):
    return replace(face, camera=replace(face.camera, translation=face.camera.translation + shift))


def test_the_mesh_covers_the_pixels_that_show_it(pictured):
    pixels = mesh_pixels(pictured.face, pictured.image)
    assert pixels.shape == pictured.mask.shape
    np.testing.assert_array_equal(pixels, pictured.mask)


def test_the_head_is_cut_out_without_its_background(pictured):
    mask = mask_head(pictured.face, pictured.image)
    both, either = (mask & pictured.mask).sum(), (mask | pictured.mask).sum()
    assert mask.dtype == bool and both > 0.85 * either
    given = mask_head(replace(pictured.face, landmarks=None), pictured.image, pictured.face.landmarks)
    np.testing.assert_array_equal(given, mask)


@pytest.mark.parametrize("function", [mesh_pixels, mask_head])
def test_a_face_beside_the_picture_is_refused(function, pictured):
    with pytest.raises(InputError, match="expected the picture that the face was fitted to, found it outside"):
        function(moved(pictured.face, 5000), pictured.image)


def test_a_face_without_camera_or_landmarks_is_refused(pictured):
    with pytest.raises(InputError, match="expected a face with the camera"):
        mask_head(replace(pictured.face, camera=None), pictured.image)
    with pytest.raises(InputError, match="expected a face with fitted landmarks"):
        mask_head(replace(pictured.face, landmarks=None), pictured.image)


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
def face(ball):
    """A fitted mesh that is narrower than the head."""
    vertices, faces = ball
    camera = Camera(1.0, np.diag([1.0, -1.0, -1.0]), CENTRE)
    return Face(Mesh(vertices * [*(0.85 * RADII), 50], faces), camera)


def zoomed(face, zoom, shift):
    """The face in a picture that is made larger and then shifted."""
    return replace(face, camera=Camera(zoom, face.camera.rotation, zoom * face.camera.translation + shift))


def picture(noise=8):
    image = np.where(ellipse((HEIGHT, WIDTH))[..., None], SKIN, PAPER)
    image = image + np.random.default_rng(0).normal(0, noise, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def overlap(first, second):
    return (first & second).sum() / (first | second).sum()


def test_a_head_is_found_by_its_colours(face, points):
    image = picture()
    mask = mask_head(face, image, points)
    truth = ellipse(image.shape)
    assert mask.shape == (HEIGHT, WIDTH) and mask.dtype == bool
    assert overlap(mask, truth) > 0.9
    # It is the colours that say so: mesh and landmarks alone are further away.
    assert overlap(mesh_pixels(face, image), truth) < 0.85


def test_large_pictures_are_cut_alike(face, points):
    large = np.repeat(np.repeat(picture(), 4, axis=0), 4, axis=1)
    mask = mask_head(zoomed(face, 4, 1.5), large, 4 * points + 1.5)
    assert mask.shape == large.shape[:2]
    assert overlap(mask, ellipse(large.shape, 4 * CENTRE + 1.5, 4 * RADII)) > 0.9


def test_something_else_of_the_same_colour_is_left_out(face, points):
    image = picture()
    image[200:235, 185:215] = SKIN
    mask = mask_head(face, image, points)
    assert not mask[205:, 190:].any() and overlap(mask, ellipse(image.shape)) > 0.9


def test_where_colours_tell_nothing_the_landmarks_do(face, points):
    mask = mask_head(face, np.full((HEIGHT, WIDTH, 3), 120, np.uint8), points)
    middle = points[list(OUTLINE)].mean(0).round().astype(int)
    assert mask[middle[1], middle[0]] and 0.1 < mask.mean() < 0.7
    assert not mask[:10].any() and not mask[:, :5].any()


@pytest.mark.parametrize("outline", [0, 1, 2])
def test_where_nothing_of_the_outline_is_known_the_other_landmarks_enclose_the_face(face, points, outline):
    eyes = np.radians(np.arange(12) * 30)
    points[36:48] = CENTRE + 0.6 * RADII * np.stack([np.cos(eyes), np.sin(eyes)], axis=1)
    points[outline:27] = np.nan
    assert overlap(mask_head(face, picture(), points), ellipse((HEIGHT, WIDTH))) > 0.85
    alike = mask_head(face, np.full((HEIGHT, WIDTH, 3), 120, np.uint8), points)
    assert overlap(alike, ellipse((HEIGHT, WIDTH), radii=0.6 * RADII)) > 0.7


@pytest.mark.parametrize("part", [(4, 5, 6), (4, 5, 6, 7), (17, 18, 19), (0, 8, 16, 20)])
def test_a_sliver_of_the_outline_does_not_enclose_the_face(face, points, part):
    eyes = np.radians(np.arange(12) * 30)
    points[36:48] = CENTRE + 0.6 * RADII * np.stack([np.cos(eyes), np.sin(eyes)], axis=1)
    points[[number for number in range(27) if number not in part]] = np.nan
    assert overlap(mask_head(face, picture(), points), ellipse((HEIGHT, WIDTH))) > 0.85


def test_a_face_that_fills_its_picture(face, points):
    mask = mask_head(zoomed(face, 1, -50), picture()[50:190, 50:170], points - 50)
    assert mask.mean() > 0.8


def test_it_is_the_same_every_time_and_changes_nothing(face, points):
    image = picture(25)
    before = image.copy()
    marks = points.copy()
    first, again = (mask_head(face, image, points) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(image, before)
    np.testing.assert_array_equal(points, marks)
