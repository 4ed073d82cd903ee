from dataclasses import replace

import cv2
import numpy as np
import pytest

from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.snap_jaw import snap_jaw
from caricli.structures.landmarks import JAW, MIRRORED, OUTLINE, Landmarks
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape

SIZE = 500
BORDER = 0.0045
"""Of the diagonal, how far the border of skin is from the head's own landmarks."""


@pytest.fixture(scope="module")
def truth(head_template):
    return space_jaw(300 * mean_shape(head_template) + [250, 230])


@pytest.fixture(scope="module")
def regions(truth):
    """A face before a background: the jaw's landmarks are as far within it as those of heads are."""
    labels = np.full((SIZE, SIZE), Region.BACKGROUND, np.uint8)
    middle = truth[:68].mean(0)
    diagonal = np.linalg.norm(np.ptp(truth, axis=0))
    away = truth[list(OUTLINE)] - middle
    border = middle + away * (1 + BORDER * diagonal / np.linalg.norm(away, axis=1, keepdims=True))
    cv2.fillPoly(labels, [np.rint(border).astype(np.int32)], int(Region.SKIN))
    return labels


def seen(points, deviation=20.0):
    return Landmarks(points, (SIZE, SIZE), np.tile(deviation**2 * np.eye(2), (len(points), 1, 1)))


def narrowed(truth, share=0.9):
    points = truth.copy()
    middle = truth[JAW].mean(0)
    points[JAW] = middle + share * (truth[JAW] - middle)
    return points


def across(marks, truth):
    """How far the jaw of landmarks is from the true one, pixels, off its ends."""
    fine = np.concatenate([np.linspace(a, b, 40) for a, b in zip(truth[:16], truth[1:17], strict=True)])
    return np.linalg.norm(marks.points[2:15, None] - fine, axis=-1).min(1).mean()


@pytest.mark.parametrize("share", [0.9, 1.08])
def test_a_jaw_goes_to_where_skin_ends(truth, regions, share):
    marks = seen(narrowed(truth, share))
    snapped = snap_jaw(regions, marks)
    assert across(snapped, truth) < 0.25 * across(marks, truth)
    np.testing.assert_array_equal(snapped.points[len(JAW) :], marks.points[len(JAW) :])


def test_it_is_surer_across_then_and_what_was_sure_stays(truth, regions):
    marks = seen(narrowed(truth))
    snapped = snap_jaw(regions, marks)
    lengths = np.linalg.eigvalsh(snapped.spreads[JAW])
    assert (lengths[4:13, 0] < 0.5 * 400).all() and (lengths[:, 0] > 0).all()
    np.testing.assert_allclose(lengths[:, 1], 400, rtol=1e-9)
    np.testing.assert_array_equal(snapped.spreads[len(JAW) :], marks.spreads[len(JAW) :])
    sure = seen(narrowed(truth), 0.1)
    assert snap_jaw(regions, sure) is sure


def test_points_beside_a_border_that_is_seen_follow(truth, regions):
    """The chin, before a neck, by what is beside it."""
    necked = regions.copy()
    left, right = (int(round(truth[k, 0])) for k in (7, 9))
    below = necked[:, left:right]
    below[below == Region.BACKGROUND] = Region.NECK
    marks = seen(narrowed(truth))
    moved = np.linalg.norm(snap_jaw(necked, marks).points[8] - marks.points[8])
    whole = np.linalg.norm(snap_jaw(regions, marks).points[8] - marks.points[8])
    assert 0.5 * whole < moved < whole


@pytest.mark.parametrize("region", [Region.HAIR, Region.NECK, Region.CLOTH, Region.OTHER])
def test_only_the_background_tells_where_a_jaw_is(truth, regions, region):
    marks = seen(narrowed(truth))
    assert snap_jaw(np.where(regions == Region.BACKGROUND, region, regions), marks) is marks


def test_a_beard_and_the_near_side_of_a_turned_face_tell_nothing(truth, regions):
    marks = seen(narrowed(truth))
    assert snap_jaw(np.where(regions == Region.SKIN, Region.BEARD, regions), marks) is marks
    turned = marks.points.copy()
    turned[27:36, 0] += 40
    snapped = snap_jaw(regions, seen(turned))
    before, after = (np.linalg.norm(points[JAW] - truth[JAW], axis=1) for points in (turned, snapped.points))
    assert after[12:15].mean() < 0.7 * before[12:15].mean()
    assert after[2:5].mean() > 0.9 * before[2:5].mean()


def test_a_mirrored_face_is_snapped_alike(truth, regions):
    order = list(MIRRORED)[: len(truth)]
    points = narrowed(truth)
    points[3] += [4, 0]
    flipped = points[order] * [-1, 1] + [SIZE - 1, 0]
    own, other = snap_jaw(regions, seen(points)), snap_jaw(regions[:, ::-1], seen(flipped))
    np.testing.assert_allclose(other.points[order] * [-1, 1] + [SIZE - 1, 0], own.points, atol=0.5)


def test_marked_landmarks_and_faces_in_part_stay(truth, regions):
    marked = replace(seen(truth), spreads=None)
    assert snap_jaw(regions, marked) is marked
    points = truth.copy()
    points[3] = np.nan
    part = Landmarks(points, (SIZE, SIZE), seen(truth).spreads)
    assert snap_jaw(regions, part) is part
