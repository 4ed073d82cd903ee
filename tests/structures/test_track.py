import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Animation, Track
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.track import LEAST, MOST, FrameError

GOOD = {
    "names": ("a", "b"),
    "times": np.array([0, 0.1, 0.3]),
    "weights": np.full((3, 2), 0.5),
    "head": np.zeros((3, 3)),
}


def changed(array, place, value):
    array = np.array(array, float)
    array[place] = value
    return array


def test_good_tracks():
    assert Track(**GOOD).head is not None
    assert Track(("a",), np.zeros(1), np.array([[LEAST]])).head is None
    Track(("a",), np.zeros(1), np.array([[MOST]]))


def test_arkit_has_52_names():
    assert len(ARKIT_NAMES) == len(set(ARKIT_NAMES)) == 52


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"names": ("a", "a")}, "names: expected distinct names, found 'a' twice"),
        ({"names": ("a", "")}, "names: expected distinct names"),
        ({"names": ()}, "names: expected distinct names, found 'an empty one'"),
        ({"names": ("a",)}, r"weights: expected the shape \(3, 1\), found \(3, 2\)"),
        ({"weights": np.zeros((2, 2))}, r"weights: expected the shape \(3, 2\), found \(2, 2\)"),
        ({"weights": np.zeros((0, 2)), "times": np.zeros(0)}, "weights: expected the shape"),
        ({"head": np.zeros((3, 2))}, r"head: expected the shape \(3, 3\), found \(3, 2\)"),
        ({"head": np.zeros((2, 3))}, "head: expected the shape"),
    ],
)
def test_parts_that_do_not_fit_are_refused(changes, words):
    with pytest.raises(InputError, match=words) as caught:
        Track(**GOOD | changes)
    assert not isinstance(caught.value, FrameError)


@pytest.mark.parametrize(
    ("changes", "frame", "words"),
    [
        ({"weights": changed(GOOD["weights"], (1, 1), np.nan)}, 1, "b: expected a weight from -0.5 to 1.5, found nan"),
        ({"weights": changed(GOOD["weights"], (2, 0), 1.6)}, 2, "a: expected a weight from -0.5 to 1.5, found 1.6"),
        (
            {"weights": changed(GOOD["weights"], (0, 0), -np.inf)},
            0,
            "a: expected a weight from -0.5 to 1.5, found -inf",
        ),
        ({"times": np.array([0.1, 0.2, 0.3])}, 0, "expected times that rise from 0, found 0.1 s"),
        ({"times": np.array([0, 0.2, 0.2])}, 2, "expected times that rise from 0, found 0.2 s"),
        ({"times": np.array([0, -0.2, 0.2])}, 1, "expected times that rise from 0, found -0.2 s"),
        ({"times": np.array([0, np.nan, 0.2])}, 1, "expected times that rise from 0, found nan s"),
        ({"head": changed(GOOD["head"], (2, 1), np.nan)}, 2, "expected angles of the head in radians"),
        ({"head": changed(GOOD["head"], (1, 0), 90)}, 1, "expected angles of the head in radians"),
    ],
)
def test_a_bad_frame_is_named(changes, frame, words):
    with pytest.raises(FrameError) as caught:
        Track(**GOOD | changes)
    error = caught.value
    assert error.frame == frame and error.problem.startswith(words) and str(error) == f"frame {frame}: {error.problem}"
    assert isinstance(error, InputError)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"times": [0.1, 0.1, 0.2]}, "times"),
        ({"times": [-0.1, 0.1, 0.2]}, "times"),
        ({"times": [1, 1 + 1e-12, 2]}, "times"),
        ({"times": [0, np.nan, 1.0]}, "times"),
        ({"times": [0, 1.0, np.inf]}, "times"),
        ({"times": [[0, 0.1, 0.2]]}, "times"),
        ({"times": []}, "times"),
        ({"weights": np.zeros((2, 4))}, "weights"),
        ({"weights": np.zeros(3)}, "weights"),
        ({"weights": np.full((3, 4), np.nan)}, "weights"),
        ({"rotations": np.ones((3, 4))}, "rotations"),
        ({"rotations": np.zeros((2, 4))}, "rotations"),
        ({"rotations": np.full((3, 4), np.nan)}, "rotations"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_what_is_no_animation_is_refused(changes, words):
    good = Animation([0, 0.1, 0.2], np.zeros((3, 4)), np.tile([0, 0, 0, 1.0], (3, 1)))
    with pytest.raises(InputError, match=f"^{words}: expected"):
        dataclasses.replace(good, **changes)


def test_a_head_that_keeps_still_may_turn():
    Animation([0.0], np.zeros((1, 0)), np.array([[1.0, 0, 0, 0]]))
