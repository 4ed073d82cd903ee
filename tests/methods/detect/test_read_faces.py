"""Where landmarks are does not depend on how the picture lies: tested without any training."""

import numpy as np
import pytest

from caricli.methods.detect.read_faces import look_at_face
from caricli.methods.detect.settings import DetectSettings
from caricli.structures.detection import FaceFrame, turn_axes
from caricli.structures.landmarks import JAW, MIRRORED

TWICE = DetectSettings(looks=2, start=0)
"""Further looks of one that has learnt nothing go anywhere."""

FRAME = FaceFrame(np.array([70.0, 60.0]), 60.0, 0.3)


@pytest.fixture(scope="module")
def picture():
    import cv2

    coarse = np.random.default_rng(0).integers(0, 256, (20, 24, 3), np.uint8)
    return cv2.resize(coarse, (144, 120), interpolation=cv2.INTER_CUBIC)


@pytest.fixture(scope="module")
def read(picture, untrained):
    return look_at_face(picture, FRAME, untrained, TWICE)


def test_mirrored(picture, untrained, read):
    frame = FaceFrame(np.array([143 - 70.0, 60.0]), 60.0, -0.3)
    other = look_at_face(picture[:, ::-1], frame, untrained, TWICE)
    order = list(MIRRORED)
    np.testing.assert_allclose(other.points[order] * [-1, 1] + [143, 0], read.points, atol=0.2)
    flip = np.diag([-1, 1])
    np.testing.assert_allclose(flip @ other.spreads[order] @ flip, read.spreads, rtol=0.1, atol=0.5)
    np.testing.assert_allclose(other.visible[order], read.visible, atol=0.02)


def test_turned_by_a_right_angle(picture, untrained, read):
    turned = np.rot90(picture, -1)  # clockwise: x, y to 119 - y, x
    frame = FaceFrame(np.array([119 - 60.0, 70.0]), 60.0, 0.3 + np.pi / 2)
    other = look_at_face(turned, frame, untrained, TWICE)
    places = np.column_stack([other.points[:, 1], 119 - other.points[:, 0]])
    # Places in the picture are rounded to a 32nd of a pixel, and random weights make much of little.
    assert np.median(np.abs(places - read.points)) < 0.25 and np.abs((places - read.points).mean(0)).max() < 0.15
    axes = turn_axes(np.pi / 2)
    apart = np.abs(axes @ other.spreads @ axes.T - read.spreads)
    assert np.median(apart) < 0.03 * np.median(np.abs(read.spreads))
    assert other.frame.roll - np.pi / 2 == pytest.approx(read.frame.roll, abs=0.02)


def test_twice_as_large(picture, untrained, read):
    larger = picture.repeat(2, axis=0).repeat(2, axis=1)
    frame = FaceFrame(2 * FRAME.centre + 0.5, 120.0, 0.3)
    other = look_at_face(larger, frame, untrained, TWICE)
    apart = np.abs((other.points - 0.5) / 2 - read.points)
    assert apart[JAW.stop :].max() < 1.5
    # A jaw of one that has learnt nothing goes to and fro, which makes much of little where it is spaced anew.
    assert apart[: JAW.stop].max() < 2.5
    assert np.median(other.spreads[:, 0, 0] / read.spreads[:, 0, 0]) == pytest.approx(4, rel=0.15)
