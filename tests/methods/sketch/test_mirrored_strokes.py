from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.sketch.mirrored_strokes import mirrored_strokes
from caricli.methods.sketch.name_strokes import name_strokes
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

FOLD = np.array([[60.0, 150], [66, 160], [64, 172], [58, 180]])
LIP = np.column_stack([np.linspace(90, 165, 20), 190 + np.sin(np.linspace(0, np.pi, 20)) * 9])


def mirror(line):
    return [255, 0] + line * [-1, 1]


@pytest.mark.parametrize("backwards", [False, True])
def test_folds_on_either_side(backwards):
    other = mirror(FOLD)[:: -1 if backwards else 1] + [4, 3]
    assert mirrored_strokes([*map(Stroke, (FOLD, LIP, other))]).tolist() == [True, False, True]


@pytest.mark.parametrize(
    "other",
    [mirror(FOLD) + [0, 40], mirror(FOLD) * [1, 0.5], FOLD + [0.5, 0], mirror(FOLD)[:2]],
    ids=["lower", "flatter", "beside it", "shorter"],
)
def test_strokes_that_are_no_pair(other):
    assert not mirrored_strokes([*map(Stroke, (FOLD, other, LIP))]).any()


def test_what_slants_alike_is_no_pair():
    brow = np.array([[60.0, 90], [75, 80], [100, 76]])
    assert not mirrored_strokes([Stroke(brow), Stroke(brow + [90, 0])]).any()
    assert mirrored_strokes([Stroke(brow), Stroke(mirror(brow))]).all()


def test_halves_of_a_mouth_meet():
    assert not mirrored_strokes([Stroke(LIP[:11]), Stroke(LIP[10:])]).any()
    assert mirrored_strokes([Stroke(LIP)]).tolist() == [False] and mirrored_strokes([]).tolist() == []


def test_folds_beside_a_mouth_are_no_lips(sketch, handles, model):
    """Of a mouth of two lines; the other two curves of it are free for whatever lies near."""
    seldom = ("eye_fold", "nostril", "nose_tip", "mouth_inner_upper", "mouth_upper")
    drawn = [stroke for stroke in sketch.strokes if not stroke.curve.startswith(seldom)]
    mouth = np.concatenate([stroke.points for stroke in sketch.strokes if stroke.curve.startswith("mouth")])
    (left, top), (right, bottom) = mouth.min(0), mouth.max(0)
    wide, high = right - left, bottom - top
    turn = np.linspace(-1.2, 1.2, 20)
    folds = [
        np.column_stack([x + side * 0.1 * wide * np.cos(turn), (top + bottom) / 2 + 0.6 * high * np.sin(turn)])
        for side, x in ((-1, left), (1, right))
    ]
    plain = [replace(stroke, curve=None, kind=StrokeKind.UNKNOWN) for stroke in drawn]
    named = name_strokes(Sketch((*plain, *map(Stroke, folds))), handles, model)
    curves = [stroke.curve for stroke in named.strokes]
    assert [curve and curve.startswith("mouth") for curve in curves[-2:]] in ([None, None], [False, False])
    assert curves[:-2] == [stroke.curve for stroke in drawn]
