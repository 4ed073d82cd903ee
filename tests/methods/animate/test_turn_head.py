import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.methods.animate.turn_head import turn_head


@pytest.mark.parametrize(
    ("angle", "point", "goes"),
    [(0, [0, 0, 1], [1, 0, 0]), (1, [0, 0, 1], [0, -1, 0]), (2, [0, 1, 0], [-1, 0, 0])],
)
def test_positive_angles_go_to_the_left_down_and_to_the_right_shoulder(angle, point, goes):
    angles = np.zeros((1, 3))
    angles[0, angle] = 0.2
    moved = Rotation.from_quat(turn_head(angles)).apply(point)[0] - point
    assert moved @ goes == pytest.approx(np.sin(0.2))


def test_pitch_and_roll_happen_in_the_turned_head():
    turn = Rotation.from_quat(turn_head([[np.pi / 2, 0.3, 0]]))
    # The nose of a head that looks to its left goes down, not sideways.
    np.testing.assert_allclose(turn.apply([0, 0, 1])[0], [np.cos(0.3), -np.sin(0.3), 0], atol=1e-12)


def test_quaternions_are_units_and_never_jump():
    angles = np.linspace([0, 0, 0], [9, 1, -5], 200)
    turns = turn_head(angles)
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1)
    assert ((turns[1:] * turns[:-1]).sum(1) > 0.99).all()
    np.testing.assert_allclose(turn_head(np.zeros((2, 3))), [[0, 0, 0, 1]] * 2)
