from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from caricli.methods.sketch.find_irises import find_irises
from caricli.methods.sketch.name_strokes import name_strokes
from caricli.methods.sketch.read_strokes import read_strokes
from caricli.methods.sketch.unsure_share import unsure_share
from caricli.store.strokes import load_strokes
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

TURN = np.linspace(0, 2 * np.pi, 60)


def ring(x, y, across, high, turn=TURN):
    return Stroke(np.column_stack([x + across / 2 * np.cos(turn), y + high / 2 * np.sin(turn)]))


def both(*strokes):
    """Strokes, and their mirror images on a canvas of 256 pixels."""
    return [*strokes, *(stroke.moved([255, 0] + stroke.points * [-1, 1]) for stroke in strokes)]


LIDS = [ring(80, 100, 40, 18, turn) for turn in (TURN[:31], TURN[29:])]
FACE = ring(127.5, 128, 180, 240)
EYES = {
    "between lids": LIDS,
    "in an almond": [ring(80, 100, 40, 18)],
    "in a round eye": [ring(80, 100, 40, 38)],
}
IRISES = {
    "iris": [ring(80, 100, 16, 16)],
    "iris and pupil": [ring(80, 100, 16, 16), ring(80, 100, 6, 6)],
    "below the lid": [ring(80, 101, 17, 17, np.linspace(-1, np.pi + 1, 40))],
    "filled": [ring(80, 100, 16, 16), Stroke(np.array([[76.0, 97], [84, 103], [77, 104]]))],
}


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("iris", IRISES)
def test_irises_and_pupils_of_both_eyes(eye, iris):
    around = [FACE, *both(*EYES[eye])]
    drawn = both(*IRISES[iris])
    assert find_irises(around + drawn)[0] == [len(around) + k for k in range(len(drawn))]
    one = [*around, *IRISES[iris]]
    assert find_irises(one) == ([], [])


def test_what_is_round_elsewhere_is_no_iris():
    nose = [ring(127.5, 150, 60, 30, turn) for turn in (TURN[:31], TURN[29:])]
    mouth = [ring(127.5, 200, 50, 40), ring(127.5, 200, 30, 28)]
    curls = [ring(x, 20, 12, 12) for x in range(60, 200, 14)]
    assert find_irises([FACE, *both(ring(110, 150, 10, 10)), *nose, *mouth, *curls]) == ([], [])
    assert find_irises([FACE, *both(ring(80, 100, 40, 38))]) == ([], [])
    glasses = [FACE, *both(ring(80, 100, 56, 44)), *both(ring(80, 100, 40, 23))]
    assert find_irises(glasses) == ([], [])
    assert find_irises([]) == ([], [])


def test_lids_are_not_looked_for_in_irises(sketch, handles, model):
    plain = Sketch(tuple(replace(stroke, curve=None, kind=StrokeKind.UNKNOWN) for stroke in sketch.strokes))
    eyes = [
        np.concatenate([s.points for s in sketch.strokes if s.curve in (f"eye_upper_{side}", f"eye_lower_{side}")])
        for side in ("left", "right")
    ]
    rings = [
        ring(*(eye.min(0) + eye.max(0)) / 2, *(2 * [share * np.ptp(eye[:, 1])])) for eye in eyes for share in (1, 0.4)
    ]
    drawn = plain.with_strokes([*plain.strokes, *rings])
    named = name_strokes(drawn, handles, model)
    count = len(plain.strokes)
    alone = name_strokes(plain, handles, model)
    assert [s.curve for s in named.strokes[:count]] == [s.curve for s in alone.strokes]
    assert {(s.kind, s.curve) for s in named.strokes[count:]} == {(StrokeKind.WRINKLE, None)}
    assert unsure_share(drawn, named, handles) <= unsure_share(plain, alone, handles)


def test_closed_lines_around_irises_are_eyes_and_glasses_beyond_are_none():
    iris = both(ring(80, 100, 12, 12))
    glasses, almonds, round_eyes = (both(ring(80, 100, *size)) for size in ((56, 44), (40, 18), (44, 46)))
    assert find_irises([FACE, *round_eyes, *iris])[1] == [1, 2]
    assert find_irises([*glasses, *almonds, *iris]) == ([4, 5], [2, 3])
    # Lids in two lines are told by their names as all others are.
    assert find_irises([*glasses, *both(*LIDS), *iris])[1] == []


@pytest.mark.parametrize("read", [None, partial(read_strokes, network=load_strokes())], ids=["alone", "read"])
def test_eyes_that_are_drawn_round_are_eyes(sketch, handles, model, read):
    """Circles far higher than lids ever are, as in comics, with pupils in them, which what is read would cut."""
    plain = [
        replace(stroke, curve=None, kind=StrokeKind.UNKNOWN) for stroke in sketch.strokes if "eye" not in stroke.curve
    ]
    for side in ("left", "right"):
        eye = np.concatenate(
            [s.points for s in sketch.strokes if s.curve in (f"eye_upper_{side}", f"eye_lower_{side}")]
        )
        x, y = (eye.min(0) + eye.max(0)) / 2
        width = 1.4 * np.ptp(eye[:, 0])
        plain += [ring(x, y, width, 1.2 * width), ring(x, y, 0.25 * width, 0.25 * width)]
    named = name_strokes(sketch.with_strokes(plain), handles, model, read=read)
    for side in ("left", "right"):
        upper, lower = (next(s for s in named.strokes if s.curve == f"eye_{lid}_{side}") for lid in ("upper", "lower"))
        assert upper.points[:, 1].mean() < lower.points[:, 1].mean()
    right, left = (
        next(s.points for s in named.strokes if s.curve == f"eye_upper_{side}") for side in ("right", "left")
    )
    assert right[:, 0].max() < left[:, 0].min()
    assert len(named.strokes) == len(plain) + 2
