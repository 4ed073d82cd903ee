import numpy as np
from scipy.spatial.transform import Rotation

from caricli.geometry.alignment.axis_similarity import axis_similarity


def test_what_was_scaled_along_axes_and_turned_comes_back():
    generator = np.random.default_rng(0)
    source = generator.normal(size=(40, 3))
    turn = Rotation.from_rotvec([0.3, -0.2, 0.4]).as_matrix()
    target = source * [1.2, 0.9, 1.0] @ turn.T + [1, 2, 3]
    scales, rotation, shift = axis_similarity(source, target)
    assert np.allclose(source * scales @ rotation.T + shift, target, atol=1e-5)


def test_no_axis_is_stretched_beyond_the_cap():
    generator = np.random.default_rng(1)
    source = generator.normal(size=(40, 3))
    scales, rotation, _ = axis_similarity(source, source * [4.0, 1.0, 0.5], uneven=1.5)
    assert scales.max() / scales.min() < 1.5 + 1e-9
    assert np.isclose(np.linalg.det(rotation), 1)
