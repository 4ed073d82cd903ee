from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.errors import CaricliError
from caricli.io.landmarks import landmarks_to_json
from caricli.methods.marks.lay_mean_shape import lay_mean_shape, middle_frame
from caricli.methods.session.history import History
from caricli.methods.session.operations import operate
from caricli.methods.session.replay import replay
from caricli.structures import Landmarks, Operation

SIZE = (320, 240)


@pytest.fixture(scope="module")
def start(tools):
    from caricli.store.session_tools import load_start

    return replace(load_start(None, tools), picture=np.zeros((SIZE[1], SIZE[0], 3), np.uint8))


@pytest.fixture(scope="module")
def laid(tools):
    return lay_mean_shape(tools.model.template, middle_frame(SIZE), SIZE)


@pytest.fixture(scope="module")
def script(laid):
    x, y = laid.points[48].tolist()
    return [
        Operation("marks", {"landmarks": landmarks_to_json(laid)}),
        Operation("mark", {"point": 48, "place": [x - 6, y + 4], "symmetric": True}),
        Operation("mark", {"point": 30, "place": laid.points[30].tolist()}),
        Operation("mark_group", {"group": "brow_left", "shift": [2, -5], "turn": 6.5, "scale": 1.1, "symmetric": True}),
        Operation("mark_off", {"points": [0, 16, 75]}),
        Operation("mark_face"),
    ]


def test_landmarks_are_placed_and_their_face_is_made(start, laid, script, tools):
    works = list(replay(start, script, tools))
    first, corner, _, brows, off, face = works
    assert np.allclose(first.landmarks.points, laid.points, atol=1e-6)
    moves = corner.landmarks.points - first.landmarks.points
    assert np.allclose(moves[[48, 54]], [[-6, 4], [6, 4]], atol=0.05) and not np.delete(moves, [48, 54], 0).any()
    assert (brows.landmarks.points[17:27, 1] < corner.landmarks.points[17:27, 1]).all()
    assert off.landmarks.known.sum() == 78 and off.face is start.face
    wanted = off.landmarks.points[off.landmarks.known]
    apart = np.linalg.norm(face.face.landmarks[off.landmarks.known] - wanted, axis=1)
    assert apart.mean() < 0.01 * off.landmarks.diagonal


def test_the_face_is_of_the_heads_own_landmarks_as_sure_as_they_are_and_has_no_strengths(start, laid):
    asked = []

    def encode(points, spreads):
        asked.append((points, spreads))
        return "new", 0

    marks = replace(laid, slides=np.full((81, 2), 0.5), spreads=np.tile(np.eye(2), (81, 1, 1)))
    work = replace(start, landmarks=marks, strengths={"Smile": 1.0}, weights={"jawOpen": 0.5})
    tools: Any = SimpleNamespace(encoder=SimpleNamespace(encode=encode))
    done = operate(work, Operation("mark_face"), tools)
    ((points, spreads),) = asked
    assert np.array_equal(points, laid.points + 0.5) and spreads is marks.spreads
    assert (done.face, done.strengths, done.weights) == ("new", {}, {})


def test_the_page_and_the_replay_make_the_same_bytes(start, script, tools):
    page = History(start, tools)
    for operation in script:
        page.do(operation)
    for _ in range(4):
        page.undo()
    assert page.work.landmarks.known.all()
    for _ in range(4):
        page.redo()
    *_, last = replay(start, script, tools)
    assert page.work.landmarks.points.tobytes() == last.landmarks.points.tobytes()
    assert page.work.face.vertices.tobytes() == last.face.vertices.tobytes()


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("marks", {}),
        ("marks", {"landmarks": {"schema": "caricli.landmarks/1", "scheme": "ibug68", "points": []}}),
        ("mark", {"point": 3}),
        ("mark", {"point": 81, "place": [1, 1]}),
        ("mark", {"point": 3.5, "place": [1, 1]}),
        ("mark", {"point": True, "place": [1, 1]}),
        ("mark", {"point": 3, "place": [1, 1, 1]}),
        ("mark", {"point": 3, "place": [5000, 1]}),
        ("mark", {"point": 3, "place": [1, 1], "symmetric": "yes"}),
        ("mark", {"point": 3, "place": [1, 1], "colour": 1}),
        ("mark_group", {}),
        ("mark_group", {"group": "hair"}),
        ("mark_group", {"group": "nose", "scale": 0}),
        ("mark_group", {"group": "nose", "turn": 999}),
        ("mark_group", {"group": "nose", "shift": 3}),
        ("mark_off", {}),
        ("mark_off", {"points": [99]}),
        ("mark_off", {"points": ["3"]}),
        ("mark_off", {"points": list(range(74))}),
        ("mark_face", {"now": True}),
    ],
)
def test_what_makes_no_sense_is_refused(start, script, tools, name, parameters):
    work = operate(start, script[0], tools)
    with pytest.raises(CaricliError, match=f"^{name}: "):
        operate(work, Operation(name, parameters), tools)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("mark", {"point": 3, "place": [1, 1]}),
        ("mark_group", {"group": "nose"}),
        ("mark_off", {"points": [3]}),
        ("mark_face", {}),
    ],
)
def test_landmarks_come_first(start, tools, name, parameters):
    with pytest.raises(CaricliError, match="expected landmarks first, found none"):
        operate(start, Operation(name, parameters), tools)


def test_landmarks_of_another_picture_are_refused(start, tools):
    far = landmarks_to_json(Landmarks(np.random.default_rng(0).uniform(900, 1200, (68, 2))))
    with pytest.raises(CaricliError, match="expected the landmarks of a face in the 320 x 240 image"):
        operate(start, Operation("marks", {"landmarks": far}), tools)


def test_landmarks_of_a_picture_of_another_size_are_refused(start, laid, tools):
    other = landmarks_to_json(replace(laid, image_size=(640, 480)))
    with pytest.raises(CaricliError, match="^marks: expected landmarks of the 320 x 240 picture, found 640 x 480"):
        operate(start, Operation("marks", {"landmarks": other}), tools)
    anywhere = landmarks_to_json(replace(laid, image_size=None))
    assert operate(start, Operation("marks", {"landmarks": anywhere}), tools).landmarks.image_size == SIZE
