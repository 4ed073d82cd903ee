import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.animate.bind_weights import bind_weights
from caricli.structures import Track


def track(*names):
    weights = np.arange(2.0 * len(names)).reshape(2, len(names)) / 10
    return Track(names, np.array([0, 0.1]), weights)


def test_names_bind_whatever_the_order():
    names = ("jawOpen", "tongueOut", "cheekPuff", "mouthLeft")
    given = track("cheekPuff", "jawOpen", "browUp")
    bound = bind_weights(given, names)
    np.testing.assert_array_equal(bound.weights[:, 0], given.weights[:, 1])
    np.testing.assert_array_equal(bound.weights[:, 2], given.weights[:, 0])
    assert not bound.weights[:, [1, 3]].any()
    assert bound.unmatched == ("browUp",) and bound.undriven == ("tongueOut", "mouthLeft")


def test_a_permuted_track_gives_the_same_weights():
    names, order = ("a", "b", "c"), [2, 0, 1]
    given = track(*names)
    permuted = Track(tuple(names[k] for k in order), given.times, given.weights[:, order])
    np.testing.assert_array_equal(bind_weights(permuted, names).weights, given.weights)


def test_only_the_first_letter_may_differ_in_case():
    bound = bind_weights(track("JawOpen", "Smile", "EYEBLINK"), ("jawOpen", "smile", "eyeBlink"))
    assert bound.unmatched == ("EYEBLINK",) and bound.undriven == ("eyeBlink",)
    both = bind_weights(track("Smile", "smile"), ("smile", "Smile"))
    assert not both.unmatched and both.weights[0].tolist() == [0.1, 0]


def test_what_cannot_be_bound_is_refused():
    with pytest.raises(InputError, match="such as jawOpen; found none of them, but x, y"):
        bind_weights(track("x", "y"), ("jawOpen",))
    with pytest.raises(InputError, match="either spelling"):
        bind_weights(track("Smile", "smile"), ("smile",))


def test_names_that_mean_the_same_action_bind_and_halves_to_their_whole():
    given = track("eyeBlinkLeft", "browInnerUp", "cheekPuff_L")
    bound = bind_weights(given, ("browInnerUp_L", "browInnerUp_R", "eyeBlink_L", "cheekPuff"))
    np.testing.assert_array_equal(bound.weights.T, given.weights.T[[1, 1, 0, 2]] * [[1], [1], [1], [0]])
    assert bound.unmatched == ("cheekPuff_L",) and bound.undriven == ("cheekPuff",)
    # A rig that has the whole action leaves its halves to those who name them.
    bound = bind_weights(given, ("browInnerUp_L", "browInnerUp"))
    assert bound.weights[1].tolist() == [0, given.weights[1, 1]]


def test_a_name_without_a_side_binds_to_both():
    given = track("mouthSmile", "eye_blink", "mouth", "cheekSquint", "mouthSmileRight")
    names = ("mouthSmile_R", "mouthSmileLeft", "eyeBlinkLeft", "eyeBlinkRight", "mouthLeft", "mouthRight")
    bound = bind_weights(given, names)
    # What names its side counts the more, whatever stands first.
    np.testing.assert_array_equal(bound.weights.T[:4], given.weights.T[[4, 0, 1, 1]])
    assert bound.unmatched == ("mouth", "cheekSquint")
    assert bound.undriven == ("mouthLeft", "mouthRight")
    with pytest.raises(InputError, match="either spelling"):
        bind_weights(track("mouthSmile", "MouthSmile"), names)


@pytest.mark.parametrize("side", ["cheekSquintLeft", "CheekSquint_R"])
def test_a_name_without_a_side_binds_to_the_one_that_is_there(side):
    given = track("mouthLeft", "cheekSquint")
    bound = bind_weights(given, (side, "mouthLeft"))
    np.testing.assert_array_equal(bound.weights, given.weights[:, [1, 0]])
    assert bound.unmatched == bound.undriven == ()
    # Left and right of a mouth undo each other: neither is meant.
    assert bind_weights(track("mouth", "cheekSquint"), (side, "mouthLeft")).unmatched == ("mouth",)
    own = bind_weights(track("cheekSquint", side), (side,))
    assert own.weights.tolist() == [[0.1], [0.3]] and own.unmatched == ()
