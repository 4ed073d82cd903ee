import numpy as np
import pytest

from caricli.structures.detection import DetectedFace, FaceFrame, turn_axes
from caricli.structures.landmarks import MIRRORED, Landmarks


@pytest.fixture
def points():
    """(81, 2) an upright face of 100 pixels: eyes above the mouth, all within a square around (60, 70)."""
    points = np.random.default_rng(0).uniform(-40, 40, (81, 2))
    points[36:48, 1] = -20
    points[48:68, 1] = 25
    points[36:68, 0] -= points[36:48, 0].mean()
    points[48:68, 0] -= points[48:68, 0].mean()
    points[36:48, 0] -= points[36:48, 0].mean()
    points[:2] = [[-50, -50], [50, 50]]
    return points + [60, 70]


def test_a_frame_holds_the_face_upright(points):
    frame = FaceFrame.of(points)
    np.testing.assert_allclose([*frame.centre, frame.side, frame.roll], [60, 70, 100, 0], atol=1e-9)
    np.testing.assert_allclose(frame.corners, [[10, 20], [110, 20], [110, 120], [10, 120]])


@pytest.mark.parametrize("angle", [0.5, -2.0, np.pi / 2])
def test_it_turns_and_grows_with_the_face(points, angle):
    turned = 2 * points @ turn_axes(angle) + [3, -4]
    frame = FaceFrame.of(turned)
    assert frame.roll == pytest.approx(angle) and frame.side == pytest.approx(200)
    np.testing.assert_allclose(frame.centre, 2 * np.array([60, 70]) @ turn_axes(angle) + [3, -4])
    # In its window every face is the same.
    windows = [FaceFrame.of(each).matrix(64, 1.6) for each in (points, turned)]
    places = [each @ m[:, :2].T + m[:, 2] for each, m in zip((points, turned), windows, strict=True)]
    np.testing.assert_allclose(*places, atol=1e-9)
    np.testing.assert_allclose(np.ptp(places[0][:68], axis=0).max(), 64 / 1.6)


def test_the_mirror_of_the_mirror_is_the_face(head_template):
    assert sorted(MIRRORED) == list(range(81)) and [MIRRORED[k] for k in MIRRORED] == list(range(81))
    points = head_template.vertices[head_template.annotation.landmarks]
    np.testing.assert_allclose(points[list(MIRRORED)] * [-1, 1, 1], points, atol=2e-3)


def test_the_spread_of_a_face_is_a_share_of_its_size(points):
    spreads = np.tile(np.diag([4.0, 5.0]), (81, 1, 1))
    face = DetectedFace(FaceFrame.of(points), 0.9, Landmarks(points, None, spreads))
    assert face.spread == pytest.approx(3 / np.linalg.norm(np.ptp(points, axis=0)))
