import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import TURNS, head_angles, head_rotation


def test_a_head_that_looks_at_the_camera():
    np.testing.assert_allclose(head_rotation(np.zeros(3)), np.diag([1.0, -1, -1]))


@pytest.mark.parametrize(("angle", "axis"), [(0, 0), (1, 1), (2, 2)])
def test_each_angle_turns_about_its_axis(angle, axis):
    angles = np.where(np.arange(3) == angle, 0.3, 0.0)
    turned = head_rotation(angles) @ np.eye(3)[axis]
    np.testing.assert_allclose(turned, np.diag([1.0, -1, -1])[axis], atol=1e-12)
    found = head_rotation(np.array([0.2, -0.4, 0.1]))
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(found) == pytest.approx(1)


def test_yaw_turns_the_nose_sideways():
    nose = head_rotation(np.array([0, 0.5, 0])) @ [0, 0, 1]
    assert abs(nose[0]) == pytest.approx(np.sin(0.5)) and nose[2] < 0


def test_angles_come_back_from_the_rotation():
    for angles in np.random.default_rng(0).uniform(-1, 1, (20, 3)) * 3 * TURNS:
        np.testing.assert_allclose(head_angles(head_rotation(angles)), angles, atol=1e-12)


def test_pitch_and_yaw_are_the_heads_own_and_roll_is_the_pictures():
    """A roll turns the picture of a head as a whole, and a yaw comes before the pitch: ears keep their height in it."""
    angles = np.array([0.3, -0.6, 0.2])
    upright = head_rotation(angles * [1, 1, 0])
    turn = np.array([[np.cos(0.2), -np.sin(0.2)], [np.sin(0.2), np.cos(0.2)]])
    np.testing.assert_allclose(head_rotation(angles)[:2], turn @ upright[:2], atol=1e-12)
    axis = upright @ [0, 1, 0]
    np.testing.assert_allclose(axis, head_rotation(angles * [1, 0, 0]) @ [0, 1, 0], atol=1e-12)
