from dataclasses import replace

import numpy as np

from caricli.methods.parts.clear_way import Bends, clear_way


class Floor:
    """Below a height, across z, nothing may be."""

    def __init__(self, height):
        self.height = height

    def room(self, points):
        return points[:, 1] - self.height, np.tile([0.0, 1.0, 0.0], (len(points), 1))


class Lip:
    """Two centimetres thick, below height zero."""

    def room(self, points):
        above = points[:, 1] + 0.01
        return np.abs(above) - 0.01, np.sign(above)[:, None] * [0.0, 1.0, 0.0]


POINTS = np.column_stack([np.zeros(5), np.linspace(0, 0.02, 5), np.zeros(5)])
AHEAD = np.tile([0.0, 0.0, 0.05], (5, 1))


def lift(low=-np.inf, wish=0.0):
    return Bends(np.tile([[0.0], [1.0], [0.0]], (5, 1, 1)), np.array([0.05]), np.array([low]), np.array([wish]))


def test_a_way_over_a_step_is_lifted_as_much_as_half_of_it_needs():
    rooms = {0.5: Floor(0.01), 1.0: Floor(0.0)}
    amounts, lack = clear_way(rooms, POINTS, AHEAD, lift(), 0.001)
    # Half of the amount has come at half of the way.
    assert 0.0215 < amounts[0] < 0.0221 and lack < 2e-4


def test_a_free_way_is_what_is_wished():
    amounts, lack = clear_way({1.0: Floor(-1.0)}, POINTS, AHEAD, lift(wish=-0.01), 0.001)
    assert amounts[0] == -0.01 and lack == 0.0


def test_what_bounds_forbid_is_said_to_lack():
    down = Bends(-lift().moves, np.array([0.05]), np.array([-0.004]), np.array([0.0]))
    amounts, lack = clear_way({1.0: Floor(0.01)}, POINTS, AHEAD, down, 0.001)
    assert -0.004 <= amounts[0] < -0.0035
    assert abs(lack - (0.011 + amounts[0])) < 1e-9


def test_what_is_bounded_from_below_never_goes_above_nothing():
    amounts, lack = clear_way({1.0: Floor(0.01)}, POINTS, AHEAD, lift(low=-0.004), 0.001)
    assert -0.004 <= amounts[0] <= 0 and abs(lack - (0.011 - amounts[0])) < 1e-9


def test_a_way_that_is_wished_through_a_wall_stays_before_it():
    rooms = {0.25: Lip(), 0.5: Lip(), 1.0: Lip()}
    amounts, lack = clear_way(rooms, POINTS + [0.0, 0.002, 0.0], AHEAD, lift(wish=-0.03), 0.001)
    assert -0.003 < amounts[0] < 0.001 and lack < 0.001


def test_where_amounts_are_first_tells_which_way_around_a_wall_is_taken():
    lip, tip, up = {1.0: Lip()}, POINTS[:1] - [0.0, 0.008, 0.0], lift()
    up = Bends(up.moves[:1], up.hold, up.low, up.wish)
    over, _ = clear_way(lip, tip, AHEAD[:1], up, 0.001)
    below, lack = clear_way(lip, tip, AHEAD[:1], replace(up, start=np.array([-0.005])), 0.001)
    assert over[0] > 0.008 and below[0] < -0.012 and lack < 2e-4
