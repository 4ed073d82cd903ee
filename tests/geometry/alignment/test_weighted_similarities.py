import numpy as np
from scipy.spatial.transform import Rotation

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.alignment.weighted_similarities import weighted_similarities


def test_as_one_by_one():
    generator = np.random.default_rng(0)
    source = generator.normal(size=(5, 9, 3))
    target = generator.normal(size=(5, 9, 3))
    for scaling in (True, False):
        scales, rotations, shifts = weighted_similarities(source, target, np.full(9, 0.5), scaling)
        for k in range(5):
            scale, rotation, shift = similarity(source[k], target[k], scaling)
            assert np.isclose(scales[k], scale)
            assert np.allclose(rotations[k], rotation) and np.allclose(shifts[k], shift)


def test_what_has_no_weight_says_nothing():
    generator = np.random.default_rng(1)
    source = generator.normal(size=(12, 3))
    turn = Rotation.from_rotvec([0.3, -0.4, 1.0]).as_matrix()
    target = 1.7 * source @ turn.T + [1, 2, 3]
    target[8:] += generator.normal(size=(4, 3))
    scale, rotation, shift = weighted_similarities(source, target, np.array([1.0, 2, 3, 1, 2, 3, 1, 2, 0, 0, 0, 0]))
    assert np.isclose(scale, 1.7) and np.allclose(rotation, turn) and np.allclose(shift, [1, 2, 3])
    assert np.isclose(np.linalg.det(rotation), 1)


def test_mirror_images_are_met_by_proper_rotations():
    source = np.random.default_rng(2).normal(size=(4, 9, 3))
    target = source * [-1.0, 1.0, 1.0] + 2
    scales, rotations, shifts = weighted_similarities(source, target, np.ones(9))
    np.testing.assert_allclose(np.linalg.det(rotations), 1)
    for k in range(4):
        scale, rotation, shift = similarity(source[k], target[k])
        assert np.isclose(scales[k], scale)
        assert np.allclose(rotations[k], rotation) and np.allclose(shifts[k], shift)


def test_sources_in_one_place_are_only_moved():
    source = np.full((2, 5, 3), 0.5)
    target = source + [[[1.0, 2, 3]], [[0, 0, -1]]]
    scales, rotations, shifts = weighted_similarities(source, target, np.ones(5))
    np.testing.assert_array_equal(scales, 1)
    np.testing.assert_allclose(scales[:, None, None] * source @ rotations.swapaxes(1, 2) + shifts[:, None], target)
