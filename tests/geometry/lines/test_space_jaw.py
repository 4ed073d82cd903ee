import numpy as np
import pytest

from caricli.geometry.lines.space_jaw import carry_jaw, jaw_shares, place_jaw, space_jaw
from tests.drawn_pictures import mean_shape


def lengths(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def test_points_of_the_jaw_stand_at_equal_distances_on_the_same_curve(head_template):
    shape = mean_shape(head_template)
    assert np.ptp(lengths(shape[:9])) > 0.5 * lengths(shape[:9]).mean()
    spaced = space_jaw(shape)
    np.testing.assert_allclose(spaced[[0, 8, 16]], shape[[0, 8, 16]], atol=1e-9)
    np.testing.assert_array_equal(spaced[17:], shape[17:])
    for side in (slice(0, 9), slice(8, 17)):
        steps = lengths(spaced[side])
        assert np.ptp(steps) < 0.08 * steps.mean()
        # As near to the old line as its corners are round.
        ends = np.stack([shape[side][:-1], shape[side][1:]], 1)
        across = ends[:, 1] - ends[:, 0]
        along = np.einsum("pld,ld->pl", spaced[side][:, None] - ends[:, 0], across) / (across**2).sum(1)
        nearest = ends[:, 0] + np.clip(along, 0, 1)[..., None] * across
        gaps = np.linalg.norm(spaced[side][:, None] - nearest, axis=2).min(1)
        assert gaps.max() < 0.1 * steps.mean()


def test_the_usual_jaw_is_carried_to_equal_distances_and_with_a_large_chin_farther_apart(head_template):
    shape = mean_shape(head_template)
    usual = carry_jaw(shape)
    np.testing.assert_allclose(usual[[0, 8, 16]], shape[[0, 8, 16]], atol=1e-9)
    np.testing.assert_array_equal(usual[17:], shape[17:])
    for side in (slice(0, 9), slice(8, 17)):
        assert np.ptp(lengths(usual[side])) < 0.08 * lengths(usual[side]).mean()
    chin = shape.copy()
    middle = shape[:, 1].mean()
    chin[:17, 1] += np.maximum(shape[:17, 1] - middle, 0)
    carried = carry_jaw(chin)
    # A point goes where the face around it goes.
    np.testing.assert_allclose(carried[:17, 0], usual[:17, 0], atol=1e-9)
    np.testing.assert_allclose(carried[6:11, 1], usual[6:11, 1] + (usual[6:11, 1] - middle), rtol=1e-6)
    assert np.ptp(lengths(carried[:9])) > 0.3 * lengths(carried[:9]).mean()


def test_points_stand_at_the_shares_at_which_they_are_placed(head_template):
    shape = mean_shape(head_template)
    shares = np.stack([np.linspace(0, 1, 9) ** 1.3, np.linspace(0, 1, 9) ** 0.8])
    placed = place_jaw(shape, shares)
    assert np.abs(jaw_shares(placed) - shares).max() < 0.01
    np.testing.assert_array_equal(placed[17:], shape[17:])
    assert np.abs(place_jaw(shape, jaw_shares(shape)) - shape).max() < 1e-9


def test_spacing_again_changes_next_to_nothing(head_template):
    once = space_jaw(mean_shape(head_template))
    assert np.abs(space_jaw(once) - once).max() < 0.02 * np.ptp(once, axis=0).max()


@pytest.mark.parametrize("jaw", [np.zeros((17, 2)), np.repeat(np.arange(17.0)[:, None] // 2, 2, 1)])
def test_points_that_fall_together_stay_finite(jaw):
    points = np.concatenate([jaw, np.ones((51, 2))])
    assert np.isfinite(space_jaw(points)).all() and np.isfinite(carry_jaw(points)).all()
