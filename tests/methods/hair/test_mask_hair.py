from dataclasses import replace

import cv2
import numpy as np
import pytest

from caricli.methods.hair.mask_hair import _bridges, mask_hair


@pytest.fixture(scope="module")
def hair_mask(sitter):
    return mask_hair(sitter.face, sitter.head, sitter.image)


def test_hair_is_told_from_skin_and_wall(hair_mask, sitter):
    truth = sitter.hair.pixels
    assert (hair_mask.pixels & truth).sum() / (hair_mask.pixels | truth).sum() > 0.95
    assert hair_mask.trusted and 0 <= hair_mask.doubt < 0.2
    assert hair_mask.behind[:40].all() and (hair_mask.behind & truth).mean() < 0.01


def test_a_bald_head_has_none(sitter):
    bald = mask_hair(sitter.face, sitter.head, sitter.bald)
    assert not bald.trusted and bald.pixels.mean() < 0.01


def test_the_mask_is_mirrored_with_the_picture(hair_mask, sitter):
    flipped = np.ascontiguousarray(sitter.image[:, ::-1])
    again = mask_hair(sitter.face, sitter.head, sitter.image)
    np.testing.assert_array_equal(again.pixels, hair_mask.pixels)
    overlap = mask_hair(sitter.face, sitter.head, flipped).pixels[:, ::-1]
    # The head is not quite in the middle, and samples are drawn: the hair is the same to a few pixels of its border.
    assert (overlap & hair_mask.pixels).sum() > 0.9 * (overlap | hair_mask.pixels).sum()


def test_a_wall_of_the_colour_of_hair_leaves_doubt(sitter):
    image = sitter.image.copy()
    image[sitter.hair.behind] = image[sitter.hair.pixels].mean(0).astype(np.uint8)
    assert not mask_hair(sitter.face, sitter.head, image).trusted


@pytest.mark.parametrize("view", ["profile", "close"])
def test_a_picture_without_skin_or_wall_has_no_hair_that_is_trusted(view, sitter):
    """Exactly from the side landmarks enclose nothing; a picture of the middle of a face shows nothing behind it."""
    face = sitter.face
    image = sitter.image
    marks = face.landmarks
    if view == "profile":
        face = replace(face, landmarks=np.column_stack([np.full(len(marks), 100.0), marks[:, 1]]))
    else:
        margin = 0.2 * np.ptp(marks, axis=0)
        low, high = np.round([marks.min(0) + margin, marks.max(0) - margin]).astype(int)
        image = np.ascontiguousarray(image[low[1] : high[1], low[0] : high[0]])
        face = replace(face, landmarks=marks - low, camera=face.camera.zoomed(1.0, low))
    mask = mask_hair(face, sitter.head, image)
    assert not mask.trusted and not mask.pixels.any() and mask.pixels.shape == image.shape[:2]


def test_a_glow_around_hair_is_the_wall(sitter):
    distance = cv2.distanceTransform(sitter.hair.behind.astype(np.uint8), cv2.DIST_L2, 5)
    glow = 90 * np.exp(-((distance / 25) ** 2)) * sitter.hair.behind
    image = np.clip(sitter.image + glow[..., None], 0, 255).astype(np.uint8)
    mask = mask_hair(sitter.face, sitter.head, image)
    truth = sitter.hair.pixels
    assert mask.trusted and (mask.pixels & truth).sum() / (mask.pixels | truth).sum() > 0.93


def test_what_thin_things_join_is_apart():
    hair = np.zeros((60, 40), bool)
    hair[5:20, 5:35] = hair[40:55, 5:35] = True
    hair[20:40, 10:12] = True
    hair[20:30, 30:32] = True
    above = np.arange(60)[:, None] < np.full(40, 10)
    bridges = _bridges(hair, above, 5)
    assert bridges[22:38, 10:12].all() and bridges.sum() <= 44
    assert not _bridges(hair, above, 1).any()
