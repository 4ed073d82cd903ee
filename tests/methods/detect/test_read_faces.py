"""Where landmarks are does not depend on how the picture lies: tested without any training."""

from types import SimpleNamespace

import numpy as np
import pytest

from caricli.methods.detect.parse_picture import WindowRegions
from caricli.methods.detect.read_faces import ReadFace, look_at_face, read_face
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.calibration import Calibration
from caricli.structures.detection import FaceFrame, turn_axes
from caricli.structures.landmarks import JAW, MIRRORED
from tests.drawn_pictures import mean_shape

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


def copier(apart, shift=(0.0, 0.0)):
    """Something that sees points in the middles of windows, to the right of them by so many pixels, and as regions
    what windows of brightness that grows evenly show, shifted by pixels."""
    order = np.arange(81)

    def read(windows):
        points = np.full((2, 81, 2), 31.5) + [apart, 0]
        spreads = np.tile(np.eye(2), (2, 81, 1, 1))
        visible = np.stack([order, order]) / 81
        values = windows.astype(float)
        regions = values[:, ::2, ::2] + shift[0] * np.gradient(values, axis=2)[:, ::2, ::2]
        return SimpleNamespace(points=points, covariance=spreads, visible=visible, regions=regions, score=np.ones(2))

    return SimpleNamespace(size=64, read=read, calibration=Calibration(shift=shift))


def test_where_a_window_and_its_mirror_image_differ_is_doubt():
    frame = FaceFrame(np.array([31.5, 31.5]), 64.0, 0.0)
    for apart in (0.0, 3.0):
        read = read_face(np.zeros((64, 64, 3), np.uint8), frame, 1.0, copier(apart))
        np.testing.assert_allclose(read.points, np.full((81, 2), 31.5), atol=1e-9)
        np.testing.assert_allclose(read.spreads, np.tile(np.diag([1 + apart**2, 1]), (81, 1, 1)), atol=1e-9)
        mirrored = np.array(MIRRORED)
        np.testing.assert_allclose(read.visible, (np.arange(81) + mirrored) / 162)


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_regions_of_both_windows_lie_on_each_other(shift):
    """Of brightness that grows from the left to the right."""
    ramp = np.broadcast_to(4 * np.arange(64, dtype=np.uint8)[:, None], (64, 64, 3))
    frame = FaceFrame(np.array([31.5, 31.5]), 64.0, 0.0)
    shown = read_face(ramp, frame, 1.0, copier(0.0, (shift, 0.0))).shown
    np.testing.assert_allclose(shown.chances[8, 1:-1, 0], 4 * (2 * np.arange(1, 31) + shift), atol=0.6)
    np.testing.assert_allclose(shown.matrix[:, 2], frame.matrix(64, 1.0)[:, 2] - [shift, 0])


def test_looks_go_on_until_their_frames_agree(monkeypatch, head_template):
    """Of one that sees a face half as far away as it is."""
    truth = 60 * mean_shape(head_template) + [200, 150]
    place = FaceFrame.of(truth)
    shares = []

    def read(_picture, frame, share, _detector):
        shares.append(share)
        points = truth + (frame.centre - place.centre) / 2
        nothing = WindowRegions(np.zeros((4, 4, 16)), np.eye(2, 3))
        return ReadFace(frame, 0.9, points, np.tile(np.eye(2), (81, 1, 1)), np.ones(81), nothing)

    monkeypatch.setattr("caricli.methods.detect.read_faces.read_face", read)
    settings = DetectSettings(looks=9)
    found = look_at_face(None, FaceFrame(place.centre + [60, 0], place.side, 0.0), None, settings)
    assert np.abs(found.points - truth).max() < 0.1 * place.side
    assert shares == [settings.first] + (len(shares) - 1) * [settings.second] and 3 < len(shares) < 9
    shares.clear()
    assert look_at_face(None, place, None, DetectSettings(start=0.95)).score == 0.9 and len(shares) == 1


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
