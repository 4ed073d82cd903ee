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


def test_a_mirror_image_is_met_by_a_proper_rotation():
    generator = np.random.default_rng(2)
    source = generator.normal(size=(40, 3))
    for uneven in (1.5, np.inf):
        scales, rotation, shift = axis_similarity(source, source * [-1.0, 1.1, 0.9] + [1, 2, 3], uneven)
        assert np.isclose(np.linalg.det(rotation), 1)
        assert np.isfinite(scales).all() and np.isfinite(shift).all()


def test_points_that_go_the_wrong_way_do_not_shrink_to_one():
    """A flat source turned inside out has no scale above zero along an axis; the others keep theirs."""
    generator = np.random.default_rng(3)
    source = generator.normal(size=(40, 3))
    scales, _, _ = axis_similarity(source, source * [-1.0, 1.0, 1.0], 1.5)
    assert scales.min() > 0.1


def test_a_plane_goes_where_its_points_do():
    """A part of one's own that has no depth: its size along it is that of the two axes that tell one."""
    source = np.random.default_rng(4).normal(size=(16, 3)) * [1, 1, 0] + [0, 0, 0.125]
    turn = Rotation.from_rotvec([0.3, -0.2, 0.4]).as_matrix()
    target = source * [1.2, 0.9, 1.0] @ turn.T + [1, 2, 3]
    scales, rotation, shift = axis_similarity(source, target, 1.5)
    np.testing.assert_allclose(source * scales @ rotation.T + shift, target, atol=1e-3)
    np.testing.assert_allclose(scales, [1.2, 0.9, np.sqrt(1.2 * 0.9)], atol=1e-3)
