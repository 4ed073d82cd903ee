from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.detect.snap_openings import snap_openings
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, EYES, LIPS_INSIDE, MOUTH
from caricli.structures.parsing import Region
from tests.grinning_face import GrinningFace

MOVED = [*EYES, *MOUTH]


@pytest.fixture(scope="module")
def face(head_template):
    return GrinningFace(head_template)


def _errors(marks, truth, part):
    return np.linalg.norm(marks.points[list(part)] - truth[list(part)], axis=1).mean()


@pytest.mark.parametrize("part", [EYES, MOUTH, LIPS_INSIDE])
def test_lips_and_lids_go_to_where_the_picture_shows_them(face, part):
    snapped = snap_openings(face.image, face.regions, face.marks)
    assert _errors(snapped, face.truth, part) < 0.5 * _errors(face.marks, face.truth, part)
    others = np.setdiff1d(np.arange(81), MOVED)
    np.testing.assert_array_equal(snapped.points[others], face.marks.points[others])


def test_they_are_surer_then_and_what_was_sure_stays(face):
    snapped = snap_openings(face.image, face.regions, face.marks)
    before, after = (np.trace(marks.spreads[MOVED], axis1=1, axis2=2) for marks in (face.marks, snapped))
    assert (after <= before).all() and (after < before).mean() > 0.9
    sure = replace(face.marks, spreads=1e-4 * face.marks.spreads)
    np.testing.assert_allclose(snap_openings(face.image, face.regions, sure).points, sure.points, atol=0.1)


def test_lids_of_eyes_larger_than_usual_ones_go_nearer_to_the_border(head_template):
    left = []
    for wide in (1.2, 1.6):
        face = GrinningFace(head_template, wide)
        marks = replace(face.marks, spreads=face.marks.spreads / 16)
        snapped = snap_openings(face.image, face.regions, marks)
        left.append(_errors(snapped, face.truth, EYES) / _errors(marks, face.truth, EYES))
    assert left[1] < 0.8 * left[0]


def test_lips_that_are_not_labelled_stay_as_thick_as_they_are(face):
    regions = np.where(face.regions == Region.LIPS, Region.SKIN, face.regions).astype(np.uint8)
    regions[face.mouth] = Region.TEETH
    snapped = snap_openings(face.image, regions, face.marks)
    for outer, inner in ((51, 62), (57, 66)):
        before, after = (marks.points[outer, 1] - marks.points[inner, 1] for marks in (face.marks, snapped))
        assert after == pytest.approx(before, abs=0.3 * abs(before))
        assert abs(snapped.points[outer, 1] - face.marks.points[outer, 1]) > 3


def test_the_corners_of_lips_go_with_those_inside(face):
    snapped = snap_openings(face.image, face.regions, face.marks)
    for outer, inner in ((48, 60), (54, 64)):
        before, after = (marks.points[outer] - marks.points[inner] for marks in (face.marks, snapped))
        np.testing.assert_allclose(after, before, atol=0.3 * np.linalg.norm(before))


def test_landmarks_that_the_picture_bears_out_stay(face):
    regions = face.regions.copy()
    regions[face.mouth] = Region.TEETH
    regions[face.eyes] = Region.EYES
    right = replace(face.marks, points=face.truth)
    assert snap_openings(face.image, regions, right) is right


def test_a_mouth_seen_from_the_side_and_an_eye_beside_another_thing_stay(face):
    points = face.marks.points.copy()
    mouth = points[list(MOUTH)]
    points[list(MOUTH)] = mouth.mean(0) + [0.2, 1] * (mouth - mouth.mean(0))
    points[list(EYE_LEFT)] += [0, 18]
    marks = replace(face.marks, points=points)
    snapped = snap_openings(face.image, face.regions, marks).points
    np.testing.assert_array_equal(snapped[[*MOUTH, *EYE_LEFT]], points[[*MOUTH, *EYE_LEFT]])
    assert np.abs(snapped[list(EYE_RIGHT)] - points[list(EYE_RIGHT)]).max() > 1


def test_marked_landmarks_and_faces_in_part_stay(face):
    marked = replace(face.marks, spreads=None)
    assert snap_openings(face.image, face.regions, marked) is marked
    points = face.marks.points.copy()
    points[3] = np.nan
    part = replace(face.marks, points=points)
    assert snap_openings(face.image, face.regions, part) is part
