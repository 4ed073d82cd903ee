from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_angles, head_rotation
from caricli.methods.pictures.pose import Pose, random_pose
from caricli.methods.pictures.settings import PoseSettings

POSE = Pose(head_rotation(np.array([0.2, -0.5, 0.1])), 300.0, np.array([50.0, 70.0]), 0.3, np.array([0, 1.6, 0]), 0.25)


def test_without_perspective_a_pixel_is_that_of_a_scaled_orthographic_camera():
    points = POSE.middle + np.random.default_rng(0).normal(0, 0.1, (20, 3))
    flat = replace(POSE, perspective=0.0).place(points)
    turned = (points - POSE.middle) @ POSE.rotation.T
    np.testing.assert_allclose(flat[:, :2], 300 * turned[:, :2] + [50, 70])
    np.testing.assert_allclose(flat[:, 2], 300 * turned[:, 2])


def test_what_is_nearer_is_larger_and_the_middle_keeps_its_size():
    """By so much that what is a head's height behind the middle is 1.3 times as small."""
    sizes = POSE.size_at(np.array([-0.25, 0, 0.25]))
    np.testing.assert_allclose(sizes, [300 / 0.7, 300, 300 / 1.3])
    ahead, behind = POSE.place(POSE.middle + np.outer([1, -1], POSE.rotation.T @ [0.1, 0, -0.2]))
    assert abs(ahead[0] - 50) > abs(behind[0] - 50) and ahead[2] < 0 < behind[2]


def test_a_head_in_millimetres_has_the_same_picture():
    points = POSE.middle + np.random.default_rng(0).normal(0, 0.1, (20, 3))
    other = replace(POSE, scale=0.3, middle=1000 * POSE.middle, height=250.0)
    np.testing.assert_allclose(other.place(1000 * points), POSE.place(points))


@pytest.mark.parametrize("filled", [0.2, 0.5, 0.9])
def test_landmarks_fill_as_much_of_the_picture_as_they_are_to(head_template, filled):
    settings = PoseSettings(perspective=0.0)
    middles = []
    for seed in range(30):
        pose = random_pose(head_template, 200, filled, np.random.default_rng(seed), settings)
        placed = pose.place(head_template.vertices[head_template.annotation.landmarks[:68]])[:, :2]
        assert np.ptp(placed, axis=0).max() == pytest.approx(filled * 200)
        middles.append((placed.min(0) + placed.max(0)) / 400 - 0.5)
    most = settings.aside if filled > settings.filled[0] else 0.5 - filled / 2 + 0.06
    assert 0.7 * most < np.abs(middles).max() <= most + 1e-9


def test_heads_turn_more_than_they_nod_and_no_farther_than_they_may(head_template):
    settings = PoseSettings(turned=0.0, rolled=0.0, yaw=20, pitch=5, roll=10, farthest=40)
    generator = np.random.default_rng(1)
    poses = [random_pose(head_template, 100, 0.5, generator, settings) for _ in range(400)]
    angles = np.degrees([head_angles(pose.rotation) for pose in poses])
    np.testing.assert_allclose(angles.std(0), [5, 19, 10], rtol=0.15)
    assert np.abs(angles[:, 1]).max() == pytest.approx(40)
    behind = random_pose(head_template, 100, 0.5, generator, replace(settings, around=180, farthest=35, yaw=200))
    assert 144 < abs(np.degrees(head_angles(behind.rotation)[1])) <= 180
