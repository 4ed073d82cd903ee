import itertools
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.geometry.lines.match_line import resample
from caricli.methods.sketch.clean_drawing import clean_drawing
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.name_strokes import _best, _likeliest, _Naming, name_strokes
from caricli.methods.sketch.nameless_strokes import NamelessStrokes
from caricli.methods.sketch.read_strokes import read_strokes
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.methods.sketch.settings import NamingSettings
from caricli.methods.sketch.strokes_read import StrokesRead
from caricli.methods.sketch.unsure_share import unsure_share
from caricli.methods.sketch.vary_sketch import vary_sketch
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.sketch_networks import load_sketch_pair
from caricli.store.strokes import load_strokes
from caricli.structures import Camera, Face
from caricli.structures.landmarks import (
    BRIDGE,
    BROW_LEFT,
    BROW_RIGHT,
    JAW,
    LOWER_LID,
    LOWER_LIP,
    LOWER_LIP_INSIDE,
    NOSTRILS,
    UPPER_LID,
    UPPER_LIP,
    UPPER_LIP_INSIDE,
)
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from caricli.template.feature_curves import named_curves
from tests.named_lines import points_by_curve


def nameless(stroke):
    return replace(stroke, curve=None, kind=StrokeKind.UNKNOWN)


def curves_of(sketch):
    return [stroke.curve for stroke in sketch.strokes]


@pytest.fixture(scope="module")
def anonymous(sketch):
    """Without names, every second stroke backwards, on another part of a larger canvas."""
    strokes = [nameless(stroke) for stroke in sketch.strokes]
    turned = [s.moved(1.5 * (s.points[::-1] if k % 2 else s.points) + [90, 20]) for k, s in enumerate(strokes)]
    return Sketch(tuple(turned), (512, 448))


def test_strokes_find_their_curves(anonymous, sketch, handles, model):
    named = name_strokes(anonymous, handles, model)
    right = [a == b for a, b in zip(curves_of(named), curves_of(sketch), strict=True)]
    assert np.mean(right) > 0.9
    assert named.strokes[0].kind == StrokeKind.SILHOUETTE
    assert all(a.points is b.points for a, b in zip(named.strokes, anonymous.strokes, strict=True))


def test_strokes_of_a_head_with_a_huge_jaw_find_their_curves(sketch, handles, model):
    """Of landmarks alone, as on real caricatures: no crown, no ears."""
    strokes = []
    for stroke in sketch.strokes:
        if stroke.curve == "silhouette":
            jaw = stroke.points[np.r_[49:66, 0:18]]
            strokes.append(replace(nameless(stroke), points=(jaw - jaw[0]) * [1, 2.2] + jaw[0]))
        elif not stroke.curve.startswith(("ear", "eye_fold", "nostril", "nose_tip")):
            strokes.append(nameless(stroke))
    expected = [
        curve for curve in curves_of(sketch) if not curve.startswith(("ear", "eye_fold", "nostril", "nose_tip"))
    ]
    named = name_strokes(Sketch(tuple(strokes), (256, 400)), handles, model)
    assert curves_of(named) == expected


@pytest.mark.slow
def test_what_a_network_sees_names_lines_of_an_unsteady_hand(handles, model):
    """Lines of unusual people that a hand moved, bent and left out."""
    right = []
    for seed in range(4):
        generator = np.random.default_rng(seed)
        person = model.decode(model.prior.colour(1.5 * generator.normal(size=len(model.prior.mean))))
        camera = canvas_camera(person, handles.curves)
        drawn = vary_sketch(draw_sketch(person, handles.curves, camera), generator)
        drawn = drawn.with_strokes(stroke for stroke in drawn.strokes if stroke.curve)
        plain = drawn.with_strokes(map(nameless, drawn.strokes))
        seen = Face(model.template.with_vertices(person), camera)
        for see in (None, lambda sketch, seen=seen: seen):
            named = curves_of(name_strokes(plain, handles, model, see=see))
            right.append(np.mean([a == b for a, b in zip(named, curves_of(drawn), strict=True)]))
    alone, told = np.mean(np.reshape(right, (-1, 2)), axis=0)
    assert told > 0.8 and told > alone + 0.1


def test_a_network_that_sees_another_face_harms_nothing(anonymous, handles, model, head_template):
    camera = Camera(4.0, np.diag([1.0, -1, -1]), np.array([20.0, 400]))
    elsewhere = Face(head_template.with_vertices(10 * head_template.vertices), camera)
    named = name_strokes(anonymous, handles, model, see=lambda sketch: elsewhere)
    assert curves_of(named) == curves_of(name_strokes(anonymous, handles, model))


@pytest.mark.parametrize("seed", [pytest.param(4, marks=pytest.mark.slow), 8])
def test_a_network_s_face_in_a_part_of_a_drawing_counts_for_nothing(handles, model, seed):
    """A head that lies on its side: the network sees a face in what is left without the outline."""
    network, basis = load_sketch_pair()
    draw = np.random.default_rng(seed).normal(size=len(model.prior.mean))
    person = model.decode(model.prior.colour(draw))
    upright = draw_sketch(person, handles.curves, canvas_camera(person, handles.curves))
    turned = (nameless(stroke).moved(stroke.points[:, ::-1] * [-1, 1] + [256, 0]) for stroke in upright.strokes)
    lying = upright.with_strokes(turned)
    alone, told = (
        sum(stroke.length for stroke in name_strokes(lying, handles, model, see=see).strokes if stroke.curve)
        for see in (None, partial(see_sketch, network=network, basis=basis))
    )
    assert told > 0.9 * alone


@pytest.mark.parametrize(
    ("seed", "seen"),
    [(11, False), (20, True)]
    + [pytest.param(*each, marks=pytest.mark.slow) for each in ((23, False), (2, True), (11, True))],
)
def test_lips_of_an_unsteady_hand_find_their_curves(seed, seen):
    """Every lip of unusual people had been left, or given to a nostril: no face laid over them had its mouth there."""
    model = load_model(kind=DEFAULT_LATENT)
    handles = LineHandles(named_curves(model.template.annotation))
    generator = np.random.default_rng(seed)
    person = model.decode(model.prior.colour(1.5 * generator.normal(size=len(model.prior.mean))))
    hand = vary_sketch(draw_sketch(person, handles.curves, canvas_camera(person, handles.curves)), generator)
    network, basis = load_sketch_pair()
    see = partial(see_sketch, network=network, basis=basis) if seen else None
    named = name_strokes(hand.with_strokes(map(nameless, hand.strokes)), handles, model, see=see)
    curves = {stroke.points.tobytes(): stroke.curve for stroke in named.strokes}
    lips = [stroke for stroke in hand.strokes if stroke.curve and stroke.curve.startswith("mouth")]
    assert lips and all(curves[stroke.points.tobytes()] == stroke.curve for stroke in lips)


def test_a_jaw_that_no_face_has_is_the_outline(sketch, handles, model):
    """Four times as long: none of the faces that are laid over it comes near."""
    features = [
        stroke for stroke in sketch.strokes if stroke.curve.startswith(("brow", "eye_upper", "nose", "mouth_u"))
    ]
    silhouette = next(stroke for stroke in sketch.strokes if stroke.curve == "silhouette")
    jaw = silhouette.points[np.r_[49:66, 0:18]]
    top = np.array([jaw[:, 0].mean(), jaw[:, 1].min()])
    long = replace(nameless(silhouette), points=(jaw - top) * [1.2, 4] + top)
    named = name_strokes(Sketch((*features, long), (400, 700)), handles, model)
    assert curves_of(named)[-1] == "silhouette" and named.strokes[-1].kind == StrokeKind.SILHOUETTE


def test_a_line_that_says_it_is_no_outline_is_none(sketch, handles, model):
    """A hat that goes around all features."""
    features = [stroke for stroke in sketch.strokes if stroke.curve.startswith(("brow", "eye", "nose", "mouth"))]
    turns = np.linspace(0, 2 * np.pi, 60)
    ring = Stroke(128 + 120 * np.stack([np.cos(turns), np.sin(turns)], 1))
    for kind, curve in ((StrokeKind.UNKNOWN, "silhouette"), (StrokeKind.FEATURE, None)):
        named = name_strokes(Sketch((*features, replace(ring, kind=kind))), handles, model)
        assert curves_of(named)[-1] == curve


@pytest.mark.parametrize(
    "parts",
    [("eye_upper", "eye_lower", "mouth_upper", "mouth_lower"), ("eye_upper", "eye_lower", "nose_", "mouth"),
     ("brow", "eye_upper", "eye_lower", "mouth_upper", "mouth_lower"),
     ("silhouette", "eye_upper", "eye_lower", "mouth_upper", "mouth_lower")],
    ids=["eyes and mouth", "eyes, nose and mouth", "brows, eyes and mouth", "no brows"],
)  # fmt: skip
def test_features_alone_find_their_curves(sketch, handles, model, parts):
    drawn = [stroke for stroke in sketch.strokes if stroke.curve.startswith(parts)]
    named = name_strokes(Sketch(tuple(map(nameless, drawn))), handles, model)
    assert curves_of(named) == [stroke.curve for stroke in drawn]


def test_two_eyes_and_a_mouth_of_a_ring_each_are_no_outline(handles, model):
    turns = np.linspace(0, 2 * np.pi, 40)
    places = [((200, 220), (28, 14)), ((312, 220), (28, 14)), ((256, 356), (60, 16))]
    rings = [Stroke(np.array(at) + np.stack([np.cos(turns), np.sin(turns)], 1) * radii) for at, radii in places]
    expected = [f"{name}_{side}" for side in ("right", "left") for name in ("eye_upper", "eye_lower")]
    named = name_strokes(Sketch(tuple(rings), (512, 512)), handles, model)
    assert curves_of(named) == [*expected, "mouth_upper", "mouth_lower"]


def test_names_that_are_given_stay_and_others_are_none(sketch, handles, model):
    brow = replace(sketch.strokes[curves_of(sketch).index("brow_left")], curve="brow_right")
    wrinkle = Stroke(np.array([[60.0, 60], [90, 62]]), StrokeKind.WRINKLE)
    strange = Stroke(np.array([[60.0, 60], [90, 62]]), StrokeKind.WRINKLE, "moustache")
    named = name_strokes(Sketch((*sketch.strokes[:1], brow, wrinkle, strange)), handles, model)
    assert curves_of(named) == ["silhouette", "brow_right", None, None]


def test_closed_eyes_and_lips_become_two_strokes(sketch, handles, model):
    lines = points_by_curve(sketch)
    pairs = [("eye_upper_left", "eye_lower_left"), ("mouth_upper", "mouth_lower")]
    rings = [Stroke(np.concatenate([lines[a], lines[b][::-1]])[5:]) for a, b in pairs]
    rings = [ring.moved(np.concatenate([ring.points[:-1], ring.points[:1]])) for ring in rings]
    others = [s for s in sketch.strokes if s.curve not in {name for pair in pairs for name in pair}]
    named = name_strokes(Sketch((*others, *rings)), handles, model)
    assert curves_of(named)[len(others) :] == [name for pair in pairs for name in pair]
    halves = {stroke.curve: stroke.points for stroke in named.strokes}
    for upper, lower in pairs:
        assert halves[upper].mean(0)[1] < halves[lower].mean(0)[1]
        assert np.linalg.norm(halves[upper][[0, -1]] - halves[lower][[-1, 0]], axis=1).max() < 1e-9 or (
            np.linalg.norm(halves[upper][[0, -1]] - halves[lower][[0, -1]], axis=1).max() < 1e-9
        )


def test_a_curve_in_two_strokes_is_one(sketch, handles, model):
    line = points_by_curve(sketch)["silhouette"]
    halves = [Stroke(line[:32]), Stroke(line[34:])]
    others = [stroke for stroke in sketch.strokes if stroke.curve != "silhouette"]
    named = name_strokes(Sketch((*others, *halves)), handles, model)
    assert curves_of(named)[-2:] == ["silhouette", "silhouette"]


@pytest.mark.parametrize("seed", [0, 1])
def test_a_line_between_nostrils_is_the_nose_where_no_wings_are_drawn(seed):
    """As landmarks have it, of unusual people; beside the wings it would be the tip."""
    model = load_model(kind=DEFAULT_LATENT)
    handles = LineHandles(named_curves(model.template.annotation))
    person = model.decode(model.prior.colour(2.0 * np.random.default_rng(seed).normal(size=len(model.prior.mean))))
    points = canvas_camera(person, handles.curves).project(person[model.template.annotation.landmarks])
    parts = [NOSTRILS, BRIDGE, JAW, BROW_RIGHT, BROW_LEFT, *UPPER_LID.values(), *LOWER_LID.values()]
    parts += [UPPER_LIP, LOWER_LIP, UPPER_LIP_INSIDE, LOWER_LIP_INSIDE]
    drawn = Sketch(tuple(Stroke(resample(points[[*part]], 48)) for part in parts))
    assert curves_of(name_strokes(drawn, handles, model))[0] == "nose"


def test_what_lies_elsewhere_draws_nothing(sketch, handles, model):
    far = Stroke(np.array([[5.0, 5], [5, 12], [3, 20]]))
    assert curves_of(name_strokes(Sketch((*sketch.strokes, far)), handles, model))[-1] is None


@pytest.mark.parametrize("cuts", [(0.3, 0.7), (0.4,)])
def test_a_nose_in_pieces_leaves_the_lips_their_strokes(sketch, handles, model, cuts):
    """Its wings and what is between them are drawn by a stroke each, and the mouth is closed, with a line between."""
    plain = [s for s in sketch.strokes if not s.curve.startswith(("eye_fold", "nostril", "nose_tip", "mouth_inner_l"))]
    strokes = []
    for stroke in plain:
        if stroke.curve == "nose":
            ends = [0, *(round(cut * (len(stroke.points) - 1)) for cut in cuts), len(stroke.points) - 1]
            strokes += [replace(stroke, points=stroke.points[a : b + 1]) for a, b in itertools.pairwise(ends)]
        else:
            strokes.append(stroke)
    named = name_strokes(Sketch(tuple(map(nameless, strokes))), handles, model)
    assert curves_of(named) == [stroke.curve for stroke in strokes]


def test_hair_and_a_neck_are_no_lines_of_a_face(sketch, handles, model):
    seldom = ("eye_fold", "nostril", "nose_tip", "mouth_inner")
    drawn = [stroke for stroke in sketch.strokes if not stroke.curve.startswith(seldom)]
    (outline,) = (stroke.points for stroke in drawn if stroke.curve == "silhouette")
    (left, top), (right, bottom) = outline.min(0), outline.max(0)
    turn = np.linspace(np.pi, 2 * np.pi, 40)
    middle, wide, high = (left + right) / 2, right - left, bottom - top
    hair = [middle, top + 0.35 * high] + np.column_stack([np.cos(turn), np.sin(turn)]) * [0.62 * wide, 0.55 * high]
    fringe = [middle, top + 0.3 * high] + np.column_stack([np.cos(turn), np.sin(turn)]) * [0.45 * wide, 0.12 * high]
    neck = [
        np.array([[middle + side * 0.3 * wide, bottom - 0.1 * high], [middle + side * 0.3 * wide, bottom + 0.2 * high],
                  [middle + side * 0.8 * wide, bottom + 0.35 * high]])
        for side in (-1, 1)
    ]  # fmt: skip
    more = tuple(map(Stroke, (hair, fringe, *neck)))
    named = name_strokes(Sketch((*map(nameless, drawn), *more), (400, 500)), handles, model)
    assert curves_of(named) == [*(stroke.curve for stroke in drawn), *4 * [None]]


def test_wrinkles_without_a_name_beside_named_curves_are_not_unsure(sketch, handles):
    wrinkle = Stroke(np.array([[100.0, 90], [156, 90]]))
    drawn = sketch.with_strokes((*sketch.strokes, *6 * [wrinkle]))
    assert unsure_share(drawn, drawn, handles) == 0
    bare = sketch.with_strokes((*sketch.strokes[:6], *6 * [wrinkle]))
    assert unsure_share(bare, bare, handles) == 1


@pytest.mark.parametrize(
    ("floor", "costs", "likeliest"), [(0, (2.0, 2.1), 1), (-3, (-1.0, -0.9), 1), (-3, (-1.0, -0.7), 0)]
)
def test_all_strokes_may_cost_a_little_more_than_the_least_that_there_is(floor, costs, likeliest):
    namings: list[Any] = [SimpleNamespace(cost=cost, floor=floor, complete=k == 1) for k, cost in enumerate(costs)]
    assert _likeliest(namings) is namings[likeliest]


@pytest.mark.parametrize(
    ("costs", "lengths", "best"), [((2, 1.99), (9, 9), 1), ((-2, -1.99), (9, 9), 0), ((2, 1), (9, 8), 0)]
)
def test_a_network_s_face_that_costs_a_little_less_counts(costs, lengths, best):
    namings: list[Any] = [
        SimpleNamespace(cost=cost, length=length) for cost, length in zip(costs, lengths, strict=True)
    ]
    assert _best(namings) is namings[best]


def test_strokes_that_a_network_is_sure_of_cost_less_than_nothing(sketch, handles, person, camera):
    names = tuple(dict.fromkeys(curves_of(sketch)))
    chances = np.array([[float(stroke.curve == name) for name in names] for stroke in sketch.strokes])
    plain = sketch.with_strokes(map(nameless, sketch.strokes))
    drawn = NamelessStrokes.of(plain, lambda each, _: StrokesRead(each, chances, names))
    own = camera.project(person[handles.vertices])
    unit = float(np.linalg.norm(np.ptp(own, axis=0)))
    naming = _Naming(drawn, handles, own, unit, NamingSettings())
    assert naming.complete and naming.floor <= naming.cost < 0


def met(named, drawn):
    """Share of the places of drawn curves that lie on a line of their name, each sketch in a box of its own."""
    boxes = [np.concatenate([stroke.points for stroke in each.strokes]) for each in (named, drawn)]
    lows, sizes = zip(*((box.min(0), np.ptp(box, axis=0).max()) for box in boxes), strict=True)
    lines: dict = {}
    for stroke in named.strokes:
        lines.setdefault(stroke.curve, []).append((resample(stroke.points, 200) - lows[0]) / sizes[0])
    shares = []
    for stroke in drawn.strokes:
        places = (resample(stroke.points, 100) - lows[1]) / sizes[1]
        own = np.concatenate(lines.get(stroke.curve, [np.full((1, 2), np.inf)]))
        shares.append((np.linalg.norm(places[:, None] - own, axis=-1).min(1) < 0.006).mean())
    return np.mean(shares)


@pytest.mark.parametrize("seed", [1, 2])
def test_lines_that_run_into_each_other_on_paper_are_told_apart(seed):
    """Where lines touch in a picture, tracing it makes strokes of several curves."""
    model = load_model(kind=DEFAULT_LATENT)
    handles = LineHandles(named_curves(model.template.annotation))
    person = model.decode(model.prior.colour(np.random.default_rng(seed).normal(size=len(model.prior.mean))))
    drawn = draw_sketch(person, handles.curves, canvas_camera(person, handles.curves))
    ink = 255 - rasterise_sketch(drawn, 900, 2.5)
    read = partial(read_strokes, network=load_strokes())
    alone, told = (
        met(name_strokes(clean_drawing(np.dstack([ink] * 3)), handles, model, read=each), drawn)
        for each in (None, read)
    )
    assert told > 0.75 and told > alone + 0.1
