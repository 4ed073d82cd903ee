import cv2
import numpy as np
import pytest

from caricli.methods.detect.cut_openings import cut_openings
from caricli.structures.parsing import Region
from tests.grinning_face import GrinningFace

LIPS = 12
"""Pixels, how thick they are."""


@pytest.fixture(scope="module")
def face(head_template):
    return GrinningFace(head_template)


def test_what_looks_as_a_part_of_an_eye_and_what_stands_between_lips_is_no_skin(face):
    openings = cut_openings(face.image, face.regions, face.marks.points)
    told = np.isin(face.regions, (Region.EYES, Region.MOUTH, Region.TEETH))
    assert told[face.eyes].mean() < 0.5 and not told[face.mouth].any()
    assert openings[face.eyes].mean() > 0.95 and openings[face.mouth].mean() > 0.95
    others = openings & ~face.eyes & ~face.mouth
    assert others.sum() < 0.5 * (face.eyes | face.mouth).sum(), "their margins"


def test_whites_are_no_skin_however_far_they_go(head_template):
    face = GrinningFace(head_template, wide=2.7)
    assert cut_openings(face.image, face.regions, face.marks.points)[face.eyes].mean() > 0.95


def test_shadows_around_eyes_are_skin(face, head_template):
    shadow = GrinningFace(head_template, wide=3).eyes & ~face.eyes
    image = np.where(shadow[..., None], np.array([80, 60, 60], np.uint8), face.image)
    assert cut_openings(image, face.regions, face.marks.points)[shadow].mean() < 0.3, "their margins"


def test_ink_that_prolongs_an_eye_is_no_skin_and_a_white_spot_beside_it_is_skin(face):
    rows, columns = np.nonzero(face.eyes[:, : face.eyes.shape[1] // 2])
    row = round(rows[columns == columns.min()].mean())
    ink, spot = (np.zeros_like(face.eyes) for _ in range(2))
    ink[row - 1 : row + 2, columns.min() - 12 : columns.min()] = True
    spot[rows.max() + 8 : rows.max() + 13, round(columns.mean()) - 3 : round(columns.mean()) + 3] = True
    image = np.where(ink[..., None], (20, 15, 20), face.image).astype(np.uint8)
    image[spot] = (235, 240, 250)
    openings = cut_openings(image, face.regions, face.marks.points)
    far = np.s_[:, columns.min() - 12 : columns.min() - 6]
    assert not cut_openings(face.image, face.regions, face.marks.points)[far][ink[far]].any()
    assert openings[ink].mean() > 0.9 and not openings[spot].any()


def test_a_shut_mouth_has_no_opening(face):
    regions = np.where(face.mouth, Region.LIPS, face.regions).astype(np.uint8)
    openings = cut_openings(face.image, regions, face.marks.points)
    rows = np.nonzero(face.mouth)[0]
    assert not openings[rows.min() : rows.max()].any()


def test_without_eyes_and_mouth_there_is_nothing(face):
    skin = np.full_like(face.regions, Region.SKIN)
    assert not cut_openings(face.image, skin, face.marks.points).any()


def test_lips_are_none_of_a_mouth_that_is_labelled_a_little_too_large(face):
    """Painted red around it, and a rim of them is labelled mouth, too."""
    mouth = face.mouth.astype(np.uint8)
    lips, labelled = (
        cv2.dilate(mouth, np.ones((2 * wide + 1, 2 * wide + 1), np.uint8)) > 0 for wide in (LIPS, LIPS // 4)
    )
    image = np.where((lips & ~face.mouth)[..., None], np.array([170, 40, 50], np.uint8), face.image)
    regions = np.where(labelled, Region.MOUTH, np.where(lips, Region.LIPS, face.regions)).astype(np.uint8)
    openings = cut_openings(image, regions, face.marks.points)
    assert openings[face.mouth].mean() > 0.95
    assert openings[lips & ~labelled].mean() < 0.4
