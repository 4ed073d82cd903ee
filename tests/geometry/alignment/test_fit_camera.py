import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.alignment.fit_camera import fit_camera
from caricli.structures import Camera

POINTS = np.random.default_rng(0).normal(size=(68, 3)) * [0.05, 0.07, 0.03] + [0.0, 0.12, 0.1]
CAMERA = np.diag([1.0, -1.0, -1.0])
VECTORS = arrays(float, 3, elements=st.floats(-1.8, 1.8))


def pose_of(vector, scale=1200.0, translation=(250.0, 300.0)):
    return Camera(scale, Rotation.from_rotvec(vector).as_matrix() @ CAMERA, np.array(translation))


def assert_same(found, expected):
    assert found.scale == pytest.approx(expected.scale, rel=1e-7)
    assert np.abs(found.rotation - expected.rotation).max() < 1e-7
    assert np.abs(found.translation - expected.translation).max() < 1e-6 * max(1, np.abs(expected.translation).max())


@settings(max_examples=80, deadline=None, derandomize=True)
@given(vector=VECTORS, scale=st.floats(1e-2, 1e5), x=st.floats(-1e4, 1e4), count=st.integers(5, 68))
def test_any_pose_is_recovered(vector, scale, x, count):
    expected = pose_of(vector, scale, (x, -x / 3))
    assert_same(fit_camera(POINTS[:count], expected.project(POINTS[:count])), expected)


def test_the_rotation_is_proper_whatever_the_noise():
    generator = np.random.default_rng(1)
    for _ in range(20):
        pixels = pose_of(generator.normal(size=3)).project(POINTS) + generator.normal(0, 20, (68, 2))
        pose = fit_camera(POINTS, pixels)
        assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
        assert pose.scale > 0


@pytest.mark.parametrize("noise", [1.0, 8.0, 40.0])
def test_nothing_near_the_fit_to_noisy_pixels_is_better(noise):
    generator = np.random.default_rng(2)
    pixels = pose_of([0.2, 0.4, -0.1]).project(POINTS) + generator.normal(0, noise, (68, 2))
    weights = generator.uniform(0.1, 1, 68)
    pose = fit_camera(POINTS, pixels, weights)
    best = (weights * ((pose.project(POINTS) - pixels) ** 2).sum(1)).sum()
    for _ in range(200):
        rotation = Rotation.from_rotvec(generator.normal(0, 1e-5, 3)).as_matrix() @ pose.rotation
        scale = pose.scale * np.exp(generator.normal(0, 1e-5))
        near = Camera(scale, rotation, pose.translation + generator.normal(0, 1e-3, 2))
        assert (weights * ((near.project(POINTS) - pixels) ** 2).sum(1)).sum() > best


def test_an_outlier_without_weight_is_not_seen():
    expected = pose_of([0.1, -0.5, 0.3])
    pixels = expected.project(POINTS)
    pixels[[3, 40]] += [[900.0, -500.0], [-2000.0, 100.0]]
    weights = np.ones(68)
    weights[[3, 40]] = 0
    assert_same(fit_camera(POINTS, pixels, weights), expected)
    assert abs(fit_camera(POINTS, pixels).scale / expected.scale - 1) > 1e-3


def test_only_ratios_of_weights_count_and_inputs_are_left_alone():
    pixels = pose_of([0.1, -0.5, 0.3]).project(POINTS) + np.random.default_rng(3).normal(0, 5, (68, 2))
    weights = np.linspace(0.1, 1, 68)
    inputs = POINTS.copy(), pixels.copy(), weights.copy()
    one, two = (fit_camera(POINTS, pixels, factor * weights) for factor in (1, 250))
    assert_same(one, two)
    assert all(np.array_equal(a, b) for a, b in zip(inputs, (POINTS, pixels, weights), strict=True))


def test_the_pose_follows_the_picture():
    """Twice the resolution and another origin change scale and translation only."""
    pixels = pose_of([0.3, 0.2, 0.1]).project(POINTS) + np.random.default_rng(4).normal(0, 5, (68, 2))
    pose = fit_camera(POINTS, pixels)
    expected = Camera(2 * pose.scale, pose.rotation, 2 * pose.translation + [10, -20])
    assert_same(fit_camera(POINTS, 2 * pixels + [10, -20]), expected)


def test_lift_undoes_project_and_keeps_the_depth():
    pose, generator = pose_of([0.4, -0.3, 0.9]), np.random.default_rng(5)
    assert np.abs(pose.lift(pose.project(POINTS), POINTS) - POINTS).max() < 1e-12
    pixels = generator.normal(200, 100, (68, 2))
    before = POINTS.copy()
    lifted = pose.lift(pixels, POINTS)
    assert np.abs(pose.project(lifted) - pixels).max() < 1e-9
    assert np.abs((lifted - POINTS) @ pose.rotation[2]).max() < 1e-12
    assert np.array_equal(POINTS, before)


def test_project_takes_batches():
    pose, shapes = pose_of([0.4, -0.3, 0.9]), np.stack([POINTS, 2 * POINTS])
    assert pose.project(shapes).shape == (2, 68, 2)
    assert np.allclose(pose.project(shapes)[1], pose.project(2 * POINTS))


@pytest.mark.parametrize(
    ("points", "pixels", "weights"),
    [
        (POINTS, np.full((68, 2), 7.0), None),
        (np.full((68, 3), 0.1), POINTS[:, :2], None),
        (POINTS[:1], POINTS[:1, :2], None),
        (POINTS, POINTS[:, :2], np.zeros(68)),
    ],
    ids=["pixels in one place", "points in one place", "one point", "no weights"],
)
def test_correspondences_that_determine_nothing_are_refused(points, pixels, weights):
    with pytest.raises(NumericsError, match="landmarks"):
        fit_camera(points, pixels, weights)


@pytest.mark.parametrize("across", [[1.0, 2.0], [-2.0, 1.0], [1.0, 0.0]])
def test_pixels_on_a_line_are_seen_by_a_proper_rotation(across):
    for seed in range(10):
        along = POINTS @ np.random.default_rng(seed).normal(size=3)
        pose = fit_camera(POINTS, 1000 * along[:, None] * across)
        assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
