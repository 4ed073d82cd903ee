import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.animate.speak_cues import act_visemes, speak_cues
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.measure_rig import curve_gap
from caricli.structures import Cues, Track
from caricli.structures.cues import SHAPES


def spoken(text, rate=60.0, length=0.1):
    """The Track of visemes of equal lengths, at rest before and after."""
    names = ("viseme_sil", *(f"viseme_{name}" for name in text.split()), "viseme_sil")
    return speak_cues(Cues(names, length * np.arange(len(names)), length * len(names)), rate)


def weight(track, name):
    return track.weights[:, track.names.index(name)]


def test_a_long_vowel_is_reached_and_a_short_one_less():
    long = weight(spoken("aa", length=0.4), "jawOpen").max()
    short = weight(spoken("aa", length=0.05), "jawOpen").max()
    assert long == pytest.approx(0.6) and 0.1 < short < 0.45


def test_nothing_jumps_and_nothing_overshoots():
    track = spoken("PP aa FF oh PP SS ou TH aa PP", 240)
    steps = np.abs(np.diff(track.weights, axis=0)).max(0)
    assert track.weights.min() >= 0 and (track.weights.max(0) <= 0.75 + 1e-9).all()
    # A mouth that held every cue would jump by all of it within one of these 4 ms.
    assert (steps < 0.2 * np.maximum(track.weights.max(0), 0.05)).all()
    turns = np.abs(np.diff(track.weights, 2, axis=0)).max(0)
    assert (turns < 0.1 * np.maximum(track.weights.max(0), 0.05)).all()
    assert not track.weights[0].any() and not track.weights[-1].any()


def test_neighbours_reach_into_each_other():
    """Lips round for oh while they still say SS."""
    rounding = weight(spoken("SS oh"), "mouthFunnel")
    assert 0.01 < rounding[10] < rounding[12] < rounding[15]
    assert not weight(spoken("SS aa"), "mouthFunnel").any()


@pytest.mark.parametrize("rate", [15.0, 24.0, 30.0, 59.94, 120.0])
@pytest.mark.parametrize("length", [0.03, 0.1])
@pytest.mark.parametrize("start", [0.2, 0.211, 0.2333])
def test_however_short_lips_close_in_a_frame_at_least(rate, length, start):
    starts = np.array([0, start, start + length])
    track = speak_cues(Cues(("viseme_aa", "viseme_PP", "viseme_aa"), starts, 0.6), rate)
    shut = weight(track, "mouthClose") >= weight(track, "jawOpen") - 1e-9
    assert shut.any() and not shut[0] and not shut[-1]
    assert (weight(track, "mouthClose") <= weight(track, "jawOpen") + 1e-12).all()


@pytest.mark.parametrize("shape", ["viseme_PP", "viseme_FF", "rhubarb_A", "rhubarb_G"])
def test_contacts_of_either_alphabet_are_whole_in_the_middle_of_a_short_cue(shape):
    alone = speak_cues(Cues((shape,), np.zeros(1), 0.5), 10)
    between = speak_cues(Cues(("viseme_aa", shape, "viseme_aa"), np.array([0, 0.4, 0.43]), 0.8), 200)
    np.testing.assert_allclose(between.weights[83], alone.weights[2], atol=1e-9)


def test_a_mouth_begins_and_ends_in_the_middle_of_a_vowel():
    track = speak_cues(Cues(("viseme_aa",), np.zeros(1), 0.5), 60)
    np.testing.assert_allclose(weight(track, "jawOpen"), 0.6)


def test_lips_that_close_beside_teeth_close_first():
    track = spoken("aa PP FF aa", length=0.06)
    shut = weight(track, "mouthClose") >= weight(track, "jawOpen") - 1e-9
    bitten = weight(track, "mouthRollLower")
    assert shut[5:15].any() and bitten.max() > 0.4 and np.flatnonzero(shut[5:15])[-1] + 5 < bitten.argmax()


def test_on_the_head_closed_lips_meet_and_vowels_open(head, head_template):
    templates = head_expressions(head, head_template)
    track = spoken("aa PP aa FF oh PP ou")
    columns = [templates.names.index(name) for name in track.names]
    upper, lower = (head_template.annotation.curves[f"mouth_inner_{side}"] for side in ("upper", "lower"))

    def gap(time):
        weights = track.weights[round(60 * time)]
        shape = templates.neutral + np.tensordot(weights, templates.deltas[columns], 1)
        return curve_gap(shape[:, :2], upper, lower)

    # The curves of the lips' insides are a little apart where the lips touch.
    rest = gap(0)
    vowel, closed, teeth, second = (gap(time) - rest for time in (0.15, 0.25, 0.45, 0.65))
    assert vowel > 0.006
    assert closed < 0.03 * vowel and second < 0.03 * vowel
    assert teeth < 0.25 * vowel


def test_frames_of_visemes_become_actions():
    weights = np.zeros((3, 24))
    weights[1, SHAPES.index("viseme_aa")] = 1
    weights[2, [SHAPES.index("viseme_aa"), SHAPES.index("viseme_PP")]] = 0.5
    track = act_visemes(Track(SHAPES, np.arange(3.0), weights, np.zeros((3, 3))))
    assert weight(track, "jawOpen") == pytest.approx([0, 0.6, 0.34])
    assert weight(track, "mouthClose") == pytest.approx([0, 0, 0.17])
    assert track.head is not None


def test_more_frames_than_a_track_has_are_refused():
    with pytest.raises(InputError, match="frames, found 80000 seconds at 60 a second"):
        speak_cues(Cues(("viseme_aa",), np.zeros(1), 80_000.0), 60)
