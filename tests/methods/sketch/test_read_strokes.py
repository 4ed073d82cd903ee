"""What the bundled network reads in strokes as people draw them."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.sketch.read_strokes import read_strokes
from caricli.store.strokes import load_strokes
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from tests.named_lines import points_by_curve

SELDOM = ("eye_fold", "nostril", "nose_tip")


@pytest.fixture(scope="module")
def network():
    return load_strokes()


@pytest.fixture(scope="module")
def usual(sketch):
    """The sketch without what is drawn seldom."""
    return sketch.with_strokes(stroke for stroke in sketch.strokes if not stroke.curve.startswith(SELDOM))


def nameless(stroke):
    return replace(stroke, curve=None, kind=StrokeKind.UNKNOWN)


def curves_of(sketch):
    return [stroke.curve for stroke in sketch.strokes]


def names_read(network, strokes, size=(256, 256)):
    return curves_of(read_strokes(Sketch(tuple(map(nameless, strokes)), size), (), network).sketch)


def test_strokes_are_read_wherever_and_however_they_are_drawn(usual, network):
    """Every second one backwards, on another part of a larger canvas."""
    turned = [s.moved(1.5 * (s.points[::-1] if k % 2 else s.points) + [90, 20]) for k, s in enumerate(usual.strokes)]
    assert names_read(network, turned, (512, 448)) == curves_of(usual)


def test_chances_are_of_the_strokes_and_add_up_to_one_at_most(usual, network):
    read = read_strokes(usual.with_strokes(map(nameless, usual.strokes)), (), network)
    assert read.chances.shape == (len(read.sketch.strokes), len(read.curves))
    assert (read.chances >= 0).all() and (read.chances.sum(1) <= 1 + 1e-6).all()
    own = [read.chances[k, read.curves.index(name)] for k, name in enumerate(curves_of(usual))]
    assert min(own) > 0.4


def test_eyes_and_lips_in_one_line_each_are_cut_at_their_corners(usual, network):
    lines = points_by_curve(usual)
    pairs = [(f"eye_upper_{side}", f"eye_lower_{side}") for side in ("left", "right")] + [
        ("mouth_upper", "mouth_lower")
    ]
    drawn = {name for pair in pairs for name in pair}
    others = [stroke for stroke in usual.strokes if stroke.curve not in drawn]
    for begin in (0, 5):
        rings = [np.concatenate([lines[a], lines[b][::-1]]) for a, b in pairs]
        strokes = [*others, *(Stroke(np.concatenate([ring[begin:], ring[1 : begin + 1]])) for ring in rings)]
        read = read_strokes(Sketch(tuple(map(nameless, strokes))), (), network).sketch
        pieces = {stroke.curve: stroke.points for stroke in read.strokes[len(others) :]}
        assert set(pieces) == drawn and len(read.strokes) == len(others) + len(drawn)
        for name, points in pieces.items():
            away = np.linalg.norm(points[[0, -1]][:, None] - lines[name][[0, -1]], axis=-1).min(1)
            assert away.max() < 0.15 * np.ptp(lines[name], axis=0).max()


def test_lines_that_run_into_each_other_are_cut(usual, network):
    """A brow, and the nose that goes on from it, in one stroke, as tracing a picture gives them."""
    lines = points_by_curve(usual)
    nose = lines["nose"] if lines["nose"][0, 0] > lines["nose"][-1, 0] else lines["nose"][::-1]
    brow = lines["brow_left"] if lines["brow_left"][0, 0] > lines["brow_left"][-1, 0] else lines["brow_left"][::-1]
    others = [stroke for stroke in usual.strokes if stroke.curve not in ("nose", "brow_left")]
    line = np.concatenate([brow, nose])
    joined = Stroke(line, pressure=np.linspace(0, 1, len(line)))
    read = read_strokes(Sketch((*map(nameless, others), joined)), (), network).sketch
    pieces = read.strokes[len(others) :]
    assert [pieces[0].curve, pieces[-1].curve] == ["brow_left", "nose"]
    for before, after in itertools.pairwise(pieces):
        np.testing.assert_array_equal(before.points[-1], after.points[0])
        assert before.pressure[-1] == after.pressure[0]
    assert pieces[0].pressure[0] == 0 and pieces[-1].pressure[-1] == 1


def test_names_that_are_given_stay_and_are_nobody_else_s(usual, network):
    brow = replace(usual.strokes[curves_of(usual).index("brow_left")], curve="nose")
    wrinkle = replace(nameless(usual.strokes[0]), kind=StrokeKind.WRINKLE)
    others = [nameless(stroke) for stroke in usual.strokes if stroke.curve != "brow_left"]
    read = read_strokes(Sketch((brow, wrinkle, *others)), (), network)
    assert read.sketch.strokes[0] is brow and read.sketch.strokes[1] is wrinkle
    assert "nose" not in curves_of(read.sketch)[1:] and (read.chances[:, read.curves.index("nose")] == 0).all()


def test_hair_and_a_neck_are_no_lines_of_a_face(usual, network):
    drawn = [stroke for stroke in usual.strokes if not stroke.curve.startswith("mouth_inner")]
    (outline,) = (stroke.points for stroke in drawn if stroke.curve == "silhouette")
    (left, top), (right, bottom) = outline.min(0), outline.max(0)
    turn = np.linspace(np.pi, 2 * np.pi, 40)
    middle, wide, high = (left + right) / 2, right - left, bottom - top
    fringe = [middle, top + 0.3 * high] + np.column_stack([np.cos(turn), np.sin(turn)]) * [0.45 * wide, 0.12 * high]
    neck = [
        np.array([[middle + side * 0.3 * wide, bottom - 0.1 * high], [middle + side * 0.3 * wide, bottom + 0.2 * high],
                  [middle + side * 0.8 * wide, bottom + 0.35 * high]])
        for side in (-1, 1)
    ]  # fmt: skip
    told = names_read(network, [*drawn, *map(Stroke, (fringe, *neck))], (400, 500))
    assert told == [*(stroke.curve for stroke in drawn), *3 * [None]]


def test_closed_lines_are_cut_into_lids_or_lips_alone(usual, network):
    """The rims of glasses run along folds of lids, but end nowhere."""
    turn = np.linspace(0, 2 * np.pi, 60)
    rims = []
    for side in ("left", "right"):
        lids = np.concatenate(
            [s.points for s in usual.strokes if s.curve in (f"eye_upper_{side}", f"eye_lower_{side}")]
        )
        middle = (lids.min(0) + lids.max(0)) / 2
        half = 0.8 * np.ptp(lids[:, 0])
        rims.append(Stroke(middle + half * np.column_stack([np.cos(turn), 0.8 * np.sin(turn)])))
    drawn = Sketch((*map(nameless, usual.strokes), *rims))
    read = read_strokes(drawn, (), network).sketch
    assert [stroke.points is rim.points for stroke, rim in zip(read.strokes[-2:], rims, strict=True)] == [True, True]


def test_strokes_that_stay_whole_get_no_name(usual, network):
    read = read_strokes(Sketch(tuple(map(nameless, usual.strokes))), (0, 3), network).sketch
    assert curves_of(read)[0] is None and curves_of(read)[3] is None and curves_of(read)[1] == usual.strokes[1].curve
