import numpy as np
import pytest

from caricli.methods.train.gesture_hand import draw_gesture, draw_other, ideal_gesture
from caricli.structures.gesture import GESTURES, roll_level


def hands(count):
    return [np.random.default_rng([5, number]) for number in range(count)]


def turning(points):
    """Turns of a stroke around itself, in whole circles."""
    ways = np.diff(points, axis=0)
    angles = np.arctan2(ways[:, 1], ways[:, 0])
    return np.abs(((np.diff(angles) + np.pi) % (2 * np.pi) - np.pi).sum()) / (2 * np.pi)


@pytest.mark.parametrize("name", GESTURES)
def test_strokes_differ_and_are_whole(name):
    strokes = [draw_gesture(name, hand) for hand in hands(20)]
    assert all(np.isfinite(stroke).all() and 16 <= len(stroke) <= 130 for stroke in strokes)
    assert len({len(stroke) for stroke in strokes}) > 5
    np.testing.assert_array_equal(draw_gesture(name, np.random.default_rng([5, 0])), strokes[0])


@pytest.mark.parametrize("name", [name for name in GESTURES if roll_level(name)])
def test_rolls_turn_as_often_as_they_say_on_their_side(name):
    for hand in hands(20):
        shape = ideal_gesture(name, hand)
        assert round(turning(shape)) == abs(roll_level(name))
        ends = (shape[0, 1] + shape[-1, 1]) / 2
        above = ends - shape[:, 1].min() > shape[:, 1].max() - ends
        assert above == (roll_level(name) > 0)  # y down


def test_arrows_point_where_they_say():
    for name, side in (("left_arrow", -1), ("right_arrow", 1)):
        for hand in hands(20):
            shape = ideal_gesture(name, hand)
            tip = shape[np.argmax(side * shape[:, 0])]
            assert abs(tip[1] - np.median(shape[:, 1])) < 0.3


def test_others_are_strokes_too():
    strokes = [draw_other(hand) for hand in hands(40)]
    assert all(len(stroke) > 10 and np.ptp(stroke, axis=0).max() > 10 for stroke in strokes)
