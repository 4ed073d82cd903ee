import numpy as np
import pytest

from caricli.structures.arkit import (
    ARKIT_NAMES,
    arkit_name,
    is_half,
    opposites,
    reachable,
    start_delta,
    uses,
    within_reach,
)


@pytest.mark.parametrize(
    ("name", "arkit"),
    [
        ("jawOpen", "jawOpen"),
        ("JawOpen", "jawOpen"),
        ("eyeBlink_L", "eyeBlinkLeft"),
        ("blendShape1.mouthSmile_R", "mouthSmileRight"),
        ("browInnerUp_L", "browInnerUp"),
        ("cheekPuff_R", "cheekPuff"),
        ("mouthLeft", "mouthLeft"),
        ("jawLeft", "jawLeft"),
        ("smile", None),
        ("jaw_L", "jawLeft"),
        ("nose_L", None),
        ("", None),
    ],
)
def test_names_that_mean_an_action(name, arkit):
    assert arkit_name(name) == arkit


def test_halves_are_those_of_whole_actions():
    assert [name for name in ARKIT_NAMES if is_half(name)] == []
    assert is_half("browInnerUp_L") and is_half("cheekPuffRight") and not is_half("eyeBlink_L") and not is_half("x_L")


@pytest.mark.parametrize("names", [("jawOpen", "mouthClose"), ("JawOpen", "blendShape1.mouthClose")])
def test_names_that_mean_actions_limit_each_other(names):
    np.testing.assert_array_equal(within_reach(np.array([[0, 1], [0.2, 1]]), names), [[0, 0], [0.2, 0.2]])


@pytest.mark.parametrize("names", [("jawOpen", "mouthClose"), ("JawOpen", "MouthClose"), ("jaw_open", "mouth_close")])
def test_names_that_mean_actions_start_from_each_other(names):
    deltas = np.random.default_rng(3).normal(size=(2, 5, 3))
    np.testing.assert_array_equal(uses(names), [[1, 0], [1, 1]])
    np.testing.assert_array_equal(start_delta(names, deltas, 0), np.zeros((5, 3)))
    np.testing.assert_array_equal(start_delta(names, deltas, 1), deltas[0])


def test_what_starts_from_an_action_starts_from_both_halves_of_it_or_from_the_whole():
    np.testing.assert_array_equal(uses(("mouthClose", "jawOpen_L", "jawOpen_R"))[0], [1, 1, 1])
    np.testing.assert_array_equal(uses(("mouthClose", "jawOpen_L", "jawOpen_R", "JawOpen"))[0], [1, 0, 0, 1])
    np.testing.assert_array_equal(uses(("mouthClose", "grin")), np.eye(2))


@pytest.mark.parametrize("names", [("mouthFrownLeft", "mouthSmileLeft"), ("MouthFrownLeft", "mouthSmile_L")])
def test_names_that_mean_actions_are_opposites(names):
    assert opposites(names) == ((1, 0),) and opposites(names[:1]) == ()


def test_of_two_halves_the_stronger_limits():
    names = ("mouthClose_L", "jawOpen_L", "jawOpen_R", "smile")
    np.testing.assert_array_equal(within_reach(np.array([[0.9, 0.2, 0.4, 2]]), names), [[0.4, 0.2, 0.4, 2]])


def test_what_is_not_there_limits_nothing():
    given = np.array([[0.7, 0.9, 0.5]])
    np.testing.assert_array_equal(within_reach(given, ("mouthClose", "eyeSquintLeft", "grin")), given)


def test_what_a_face_does_not_do_limits_what_it_does():
    assert reachable({"mouthClose": 1.0}) == {"mouthClose": 0.0}
    assert reachable({"mouthClose": 1.0, "jawOpen": 0.5}) == {"mouthClose": 0.5, "jawOpen": 0.5}
    assert reachable({"eyeSquintLeft": 0.5}) == {"eyeSquintLeft": 0.5}
