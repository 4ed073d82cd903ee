from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.texture.head_picture import HeadPicture


@pytest.fixture(scope="module")
def aside(pictured):
    """The head in a much larger picture, whose own picture begins at column 700 and row 900, and labels of it."""
    image = np.zeros((2000, 2400, 3), np.uint8)
    rows, columns = pictured.mask.shape
    part = np.s_[900 : 900 + rows, 700 : 700 + columns]
    image[part] = pictured.image
    mask = np.zeros(image.shape[:2], bool)
    mask[part] = pictured.mask
    corner = np.array([700, 900])
    face = replace(
        pictured.face,
        camera=pictured.face.camera.zoomed(1.0, -corner),
        landmarks=pictured.face.landmarks + corner,
    )
    return HeadPicture(face, image, mask, 3 * mask.astype(np.uint8))


def test_what_is_near_the_head_is_as_it_was(aside, pictured):
    near = aside.near_head(10_000)
    assert near.mask.sum() == aside.mask.sum()
    np.testing.assert_array_equal(near.regions, 3 * near.mask)
    start = (aside.face.landmarks - near.face.landmarks)[0]
    np.testing.assert_allclose(start, np.round(start), atol=1e-9)
    column, row = np.round(start).astype(int)
    width, height = near.size
    np.testing.assert_array_equal(near.image, aside.image[row : row + height, column : column + width])
    np.testing.assert_allclose(
        near.face.camera.project(near.face.vertices) + start, aside.face.camera.project(aside.face.vertices), atol=1e-6
    )
    assert abs(near.share - width * height / (2000 * 2400)) < 1e-12 and near.share < 0.5


def test_a_head_of_many_pixels_has_fewer(aside):
    whole = aside.near_head(10_000)
    near = aside.near_head(100)
    extent = np.ptp(near.face.camera.project(near.face.vertices), axis=0).max()
    assert abs(extent - 100) < 1e-6
    assert abs(near.mask.mean() - whole.mask.mean()) < 0.01 and near.share == whole.share
    rows, columns = np.nonzero(near.mask)
    places = near.face.camera.project(near.face.vertices)
    np.testing.assert_allclose([columns.min(), rows.min()], places.min(0), atol=1.5)
    np.testing.assert_allclose([columns.max(), rows.max()], places.max(0), atol=1.5)
    inside = near.image[near.mask].mean(0)
    np.testing.assert_allclose(inside, whole.image[whole.mask].mean(0), atol=3)


def test_a_head_outside_of_the_picture_has_no_part_of_it(pictured):
    away = replace(pictured.face, camera=pictured.face.camera.zoomed(1.0, (5000, 5000)))
    picture = HeadPicture(away, pictured.image)
    assert picture.near_head(100) is picture
