import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.alignment.rotation_vectors import rotation_matrices, rotation_vectors


def _vectors(angle: float) -> np.ndarray:
    axes = np.random.default_rng(5).normal(size=(7, 30, 3))
    axes[0, :9] = np.repeat(np.eye(3), 3, axis=0)
    return angle * axes / np.linalg.norm(axes, axis=-1, keepdims=True)


@pytest.mark.parametrize("angle", [0, 1e-300, 1e-12, 1e-5, 0.3, 1.7, 3.1, np.pi - 1e-9])
def test_vectors_and_matrices_are_those_of_scipy(angle):
    vectors = _vectors(angle)
    expected = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(7, 30, 3, 3)
    np.testing.assert_allclose(rotation_matrices(vectors), expected, rtol=0, atol=2e-15)
    np.testing.assert_allclose(rotation_vectors(expected), vectors, rtol=0, atol=2e-15 if angle < 3 else 1e-9)


def test_half_turns_come_back_as_half_turns():
    vectors = _vectors(np.pi)
    back = rotation_vectors(rotation_matrices(vectors))
    np.testing.assert_allclose(np.linalg.norm(back, axis=-1), np.pi, rtol=1e-12)
    np.testing.assert_allclose(np.abs((back * vectors).sum(-1)), np.pi**2, rtol=1e-12)


def test_what_does_not_turn_has_no_vector():
    np.testing.assert_array_equal(rotation_vectors(np.eye(3)), 0)
    np.testing.assert_array_equal(rotation_matrices(np.zeros((2, 3))), np.tile(np.eye(3), (2, 1, 1)))
