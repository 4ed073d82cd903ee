import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.gesture.selection import Selection
from caricli.methods.session.gesture_operations import REDO, UNDO, meaning_of, selection_of, view_of
from caricli.methods.session.operations import operate
from caricli.methods.session.play_gestures import play_gestures
from caricli.methods.session.replay import replay
from caricli.methods.train.gesture_hand import GestureHandSettings, draw_gesture
from caricli.structures import Camera, Operation
from caricli.structures.gesture import GESTURES
from tests.seen_views import view_parameters

CAMERA = Camera(1600.0, np.diag([1.0, -1, -1]), np.array([210.0, 200.0]))
VIEW = view_parameters(CAMERA)
CALM = GestureHandSettings(turn=0, slant=0, stretch=0, tremor=0, cut=0, past=0, points=(60, 90))


@pytest.fixture(scope="module")
def tip(start, tools):
    return CAMERA.project(start.face.vertices[tools.model.template.annotation.landmarks[30]])


def ring(centre, radius=30):
    turns = np.linspace(0, 2 * np.pi, 40)
    return (centre + radius * np.stack([np.cos(turns), np.sin(turns)], 1)).tolist()


def stroke(name, seed=0):
    points = draw_gesture(name, np.random.default_rng(seed), CALM)
    return Operation("gesture", {"points": points.tolist(), "camera": VIEW})


def test_a_script_does_what_it_says(start, tools, tip):
    nose = [tip.tolist(), (tip + [0, 3]).tolist()]
    script = [
        Operation("region", {"points": ring(tip), "camera": VIEW}),
        Operation("bulge", {"level": 3}),
        Operation("depress", {"level": 1, "symmetric": True}),
        Operation("brush", {"points": nose, "radius": 8, "camera": VIEW}),
        Operation("line", {"points": [tip.tolist(), (tip + [0, 9]).tolist()], "camera": VIEW}),
        Operation("brush", {"points": nose, "radius": 30, "camera": VIEW, "erase": True}),
        Operation("deselect"),
    ]
    works = list(replay(start, script, tools))
    again = list(replay(start, script, tools))
    assert works[-1].face.vertices.tobytes() == again[-1].face.vertices.tobytes()
    chosen, raised, pressed, marked, lower, erased, nothing = works
    number = int(tools.model.template.annotation.landmarks[30])
    out = [work.face.vertices[number, 2] for work in (start, raised, pressed)]
    assert out[1] > out[2] > out[0]
    assert len(marked.handles) and not len(erased.handles) and erased.region is not None
    assert lower.face.vertices[number, 1] < pressed.face.vertices[number, 1] - 0.003
    assert nothing.region is None and not len(nothing.skin)
    assert np.array_equal(chosen.face.latent, lower.face.latent) and lower.face.model_id == start.face.model_id
    assert np.abs(lower.face.residual).max() > 0
    assert np.array_equal(selection_of(nothing).region, Selection().region)


def test_strokes_are_what_the_network_takes_them_for(tools):
    for name in GESTURES:
        meant = meaning_of(stroke(name), tools)
        if name.endswith("_arrow"):
            assert meant == (UNDO if name == "left_arrow" else REDO)
        else:
            expected = {"line": "line", "region": "region"}.get(name, "bulge" if "up" in name else "depress")
            assert isinstance(meant, Operation) and meant.name == expected
            assert meant.parameters.get("level", int(name[-1]) if "roll" in name else None) == (
                int(name[-1]) if "roll" in name else None
            )


def test_arrows_undo_and_redo(start, tools, tip):
    region = Operation("region", {"points": ring(tip), "camera": VIEW})
    played = play_gestures(start, [region, stroke("up_roll_2"), stroke("left_arrow")], tools)
    assert [each.name for each in played.done] == ["region"] and len(played.undone) == 1
    again = play_gestures(
        start, [region, stroke("up_roll_2"), stroke("left_arrow"), stroke("right_arrow"), stroke("down_roll_1")], tools
    )
    assert [each.name for each in again.done] == ["region", "bulge", "depress"]
    assert dict(again.done[1].parameters) == {"level": 2}
    with pytest.raises(InputError, match=r"^gesture: expected a stroke that changes the face, found undo"):
        operate(start, stroke("left_arrow"), tools)


def test_a_stroke_that_may_be_anything_is_refused(start, tools):
    scribble = np.random.default_rng(0).normal(size=(40, 2)).cumsum(0)[np.random.default_rng(1).permutation(40)]
    with pytest.raises(InputError, match=r"^operation 0: .*may be anything"):
        play_gestures(start, [Operation("gesture", {"points": scribble.tolist(), "camera": VIEW})], tools)


@pytest.mark.parametrize(
    "operation",
    [
        Operation("region", {"points": [[0, 0], [1, 1], [2, 0]]}),
        Operation("region", {"points": [[0, 0], [1, 1], [2, 0]], "camera": VIEW | {"scale": 0}}),
        Operation("line", {"points": [[0, 0], [1, 1]], "camera": VIEW | {"rotation": np.eye(3)[:2].tolist()}}),
        Operation("line", {"points": [[0, 0], [1, 1]], "camera": VIEW | {"rotation": (-np.eye(3)).tolist()}}),
        Operation("line", {"points": [[0, 0], [1, 1]], "camera": VIEW | {"translation": [1]}}),
        Operation("line", {"points": [[0, 0], [1, 1]], "camera": VIEW | {"lens": 1}}),
        Operation("bulge", {"level": 4}),
        Operation("bulge", {"level": 1.5}),
        Operation("depress", {"level": 1, "symmetric": 1}),
        Operation("bulge", {"level": 1}),
        Operation("brush", {"points": [[0, 0]], "radius": 0, "camera": VIEW}),
        Operation("deselect", {"all": True}),
    ],
)
def test_what_makes_no_sense_is_refused(start, tools, operation):
    with pytest.raises(InputError, match=f"^{operation.name}: "):
        operate(start, operation, tools)


def test_a_view_comes_back(start):
    again = view_of(Operation("line", {"camera": VIEW}).parameters)
    np.testing.assert_allclose(again.project(start.face.vertices), CAMERA.project(start.face.vertices), atol=1e-3)
