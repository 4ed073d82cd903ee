import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from caricli.geometry.alignment.similarity import similarity

SOURCE = np.random.default_rng(0).normal(size=(12, 3)) * [1.0, 2.0, 0.5]


def error(source, target, scale, rotation, translation):
    return ((scale * source @ rotation.T + translation - target) ** 2).sum()


@settings(max_examples=50, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), scale=st.floats(1e-3, 1e3), shift=st.floats(-100, 100))
def test_a_similarity_is_recovered(seed, scale, shift):
    rotation = Rotation.random(random_state=seed).as_matrix()
    target = scale * SOURCE @ rotation.T + [shift, 1.0, -shift]
    found = similarity(SOURCE, target)
    assert found[0] == pytest.approx(scale, rel=1e-9)
    assert np.abs(found[1] - rotation).max() < 1e-9 * max(1, 100 / scale)
    assert np.abs(found[2] - [shift, 1.0, -shift]).max() < 1e-9 * max(1, scale, abs(shift))


@pytest.mark.parametrize("scaling", [True, False])
def test_nothing_near_the_fit_to_noisy_points_is_better(scaling):
    generator = np.random.default_rng(1)
    target = 1.7 * SOURCE @ Rotation.random(random_state=3).as_matrix().T + generator.normal(0, 0.3, SOURCE.shape)
    scale, rotation, translation = similarity(SOURCE, target, scaling)
    best = error(SOURCE, target, scale, rotation, translation)
    for _ in range(100):
        turned = Rotation.from_rotvec(generator.normal(0, 1e-2, 3)).as_matrix() @ rotation
        scaled = scale * np.exp(generator.normal(0, 1e-2)) if scaling else scale
        assert error(SOURCE, target, scaled, turned, translation + generator.normal(0, 1e-2, 3)) > best


def test_points_of_a_plane_stay_in_it():
    rotation = np.array([[0.6, -0.8], [0.8, 0.6]])
    scale, turn, shift = similarity(SOURCE[:, :2], 2 * SOURCE[:, :2] @ rotation.T + [3, 4])
    np.testing.assert_allclose(turn, rotation, atol=1e-12)
    np.testing.assert_allclose([scale, *shift], [2, 3, 4], atol=1e-12)
    assert np.linalg.det(similarity(SOURCE[:, :2], SOURCE[:, :2] * [-1, 1])[1]) == pytest.approx(1)


def test_reflected_points_get_a_proper_rotation():
    target = SOURCE * [-1, 1, 1]
    scale, rotation, translation = similarity(SOURCE, target)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert np.allclose(rotation @ rotation.T, np.eye(3))
    best = error(SOURCE, target, scale, rotation, translation)
    others = Rotation.random(2000, random_state=4).as_matrix()
    assert 0 < best <= min(error(SOURCE, target, scale, other, translation) for other in others)
    for factor in (0.99, 1.01):
        centre = target.mean(0) - factor * scale * rotation @ SOURCE.mean(0)
        assert error(SOURCE, target, factor * scale, rotation, centre) > best


def test_points_in_one_plane_are_enough():
    flat = SOURCE * [1, 1, 0]
    rotation = Rotation.random(random_state=5).as_matrix()
    assert np.allclose(similarity(flat, 2 * flat @ rotation.T)[1], rotation)


def test_without_scaling_the_transform_is_rigid():
    rotation = Rotation.random(random_state=6).as_matrix()
    scale, found, translation = similarity(SOURCE, 5 * SOURCE @ rotation.T + 1, scaling=False)
    assert scale == 1.0
    assert np.allclose(found, rotation)
    assert np.allclose(SOURCE.mean(0) @ found.T + translation, 5 * SOURCE.mean(0) @ rotation.T + 1)
