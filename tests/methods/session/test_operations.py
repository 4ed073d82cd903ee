import tracemalloc
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from caricli.errors import CaricliError, InputError
from caricli.methods.session.draw_operations import rubbed
from caricli.methods.session.history import History
from caricli.methods.session.operations import OPERATIONS, operate
from caricli.methods.session.replay import replay
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.structures import Operation, Stroke
from caricli.template.feature_curves import feature_curves

TURN = np.linspace(0, 2 * np.pi, 60)
OUTLINE = np.stack([256 + 150 * np.cos(TURN), 260 + 190 * np.sin(TURN)], axis=1).tolist()
EYES = [np.stack([x + 30 * np.cos(TURN), 230 + 12 * np.sin(TURN)], axis=1).tolist() for x in (195, 317)]
SCRIPT = [
    Operation("draw", {"points": OUTLINE, "pressure": [0.5] * 60, "width": 2.0}),
    *(Operation("draw", {"points": eye}) for eye in EYES),
    Operation("erase", {"points": [[347, 230]], "radius": 9}),
    Operation("semantic", {"strengths": {"BigNose": 1.5}, "keep": ["BigMouth"]}),
    Operation("caricaturize", {"strength": 0.5}),
    Operation("handle", {"handles": {"nose_tip": [0, 0, 0.01]}, "pins": ["chin"], "symmetric": False}),
    Operation("expression", {"weights": {"mouthSmileLeft": 0.5, "jawOpen": 0.25}}),
    Operation("expression", {"weights": {"jawOpen": 0}}),
]


@pytest.fixture(scope="module")
def works(start, tools):
    return list(replay(start, SCRIPT, tools))


def test_every_operation_does_what_it_says(start, works, tools):
    drawn, _, both, rubbed, nosed, drawing, pulled, smiling, closed = works
    assert len(both.sketch.strokes) == 3 and drawn.face.camera is not None
    outline = both.face.camera.project(both.face.vertices)
    assert abs(np.ptp(outline[:, 1]) / 380 - 1) < 0.25  # as high as it was drawn
    assert len(rubbed.sketch.strokes) == 3 and len(rubbed.sketch.strokes[-1].points) < 60
    assert nosed.strengths == {"BigNose": 1.5} and drawing.strengths == {"BigNose": 1.5, "Caricature": 0.5}
    tip = tools.model.template.annotation.landmarks[30]
    moved = (pulled.face.vertices - drawing.face.vertices)[tip]
    assert np.abs(moved - [0, 0, 0.01]).max() < 2e-3
    assert dict(smiling.weights) == {"jawOpen": 0.25, "mouthSmileLeft": 0.5}
    assert dict(closed.weights) == {"mouthSmileLeft": 0.5}
    assert closed.face is pulled.face


def test_the_page_and_the_replay_make_the_same_bytes(start, works, tools):
    page = History(start, tools)
    for operation in SCRIPT:
        page.do(operation)
    for _ in range(5):
        page.undo()
    for _ in range(5):
        page.redo()
    assert page.work.face.vertices.tobytes() == works[-1].face.vertices.tobytes()
    assert page.work.face.residual.tobytes() == works[-1].face.residual.tobytes()


def test_sums_are_made_by_one_thread_on_any_number_of_cores(start, tools, monkeypatch):
    threads = []

    def count(work, parameters, tools):
        threads.extend(pool["num_threads"] for pool in threadpool_info())
        return work

    monkeypatch.setitem(OPERATIONS, "draw", count)
    with threadpool_limits(2):
        assert max(pool["num_threads"] for pool in threadpool_info()) == 2
        operate(start, Operation("draw", {}), tools)
    assert threads and set(threads) == {1}


def test_an_empty_canvas_is_the_mean_face(start, works, tools):
    cleared = operate(works[-1], Operation("clear"), tools)
    assert not cleared.sketch.strokes and np.array_equal(cleared.face.vertices, start.face.vertices)
    rubbed = operate(works[0], Operation("erase", {"points": [[256, 260]], "radius": 900}), tools)
    assert not rubbed.sketch.strokes and np.array_equal(rubbed.face.vertices, start.face.vertices)


@pytest.mark.parametrize(
    ("drawn", "operation"),
    [
        (True, Operation("erase", {"points": [[5, 5]], "radius": 2})),
        (False, Operation("erase", {"points": [[256, 256]], "radius": 900})),
        (False, Operation("clear")),
    ],
)
def test_what_meets_no_stroke_leaves_the_face(start, works, tools, drawn, operation):
    work = works[-1] if drawn else replace(works[-1], sketch=start.sketch)
    after = operate(work, operation, tools)
    assert after.face is work.face and after.sketch is work.sketch
    assert after.strengths == work.strengths and after.weights == work.weights


def test_lines_can_be_followed(start, tools):
    template = tools.model.template
    face = tools.model.decode(1.5 * tools.model.prior.factor[:, 0] + tools.model.prior.mean)
    curves = feature_curves(template.annotation)
    lines = draw_sketch(face, curves, canvas_camera(face, curves, side=512), (512, 512)).strokes
    drawn = replace(start, sketch=start.sketch.with_strokes(Stroke(line.points.round(6)) for line in lines))
    near, half = (operate(drawn, Operation("follow", {"share": share}), tools) for share in (1.0, 0.5))
    assert "of the canvas away" in near.remark and not operate(near, Operation("clear"), tools).remark
    camera = near.face.camera
    gaps = {
        line.curve: np.linalg.norm(camera.project(near.face.vertices[curve.vertices]) - line.points, axis=1).mean()
        for line, curve in zip(lines, curves, strict=True)
    }
    assert np.median(list(gaps.values())) < 1.5  # pixels of 512
    assert np.abs(near.face.vertices - half.face.vertices).max() > 1e-4 and near.sketch is drawn.sketch


def test_an_eraser_takes_what_is_nearer_to_its_path_than_its_radius():
    rng = np.random.default_rng(0)
    line = Stroke(np.cumsum(rng.normal(0, 4, (400, 2)), axis=0), pressure=rng.random(400))
    path = rng.normal(0, 40, (5, 2))
    share = np.linspace(0, 1, 4001)[:, None]
    everywhere = np.concatenate([a + share * (b - a) for a, b in pairwise(path)])
    left = [min(np.linalg.norm(everywhere - point, axis=1)) > 12 for point in line.points]
    runs = [list(run) for stays, run in groupby(range(400), key=left.__getitem__) if stays]
    pieces = rubbed(line, path, 12)
    assert len(pieces) > 2
    for piece, run in zip(pieces, [run for run in runs if len(run) > 1], strict=True):
        assert np.array_equal(piece.points, line.points[run]) and np.array_equal(piece.pressure, line.pressure[run])


def test_a_long_way_of_an_eraser_takes_no_memory():
    line = Stroke(np.array([[-3.0, 0], [-2, 1], [5, 2], [1e5, -0.05]]))
    tracemalloc.start()
    try:
        (piece,) = rubbed(line, np.array([[-1e6, 0], [1e6, 0]]), 0.1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert np.array_equal(piece.points[:2], line.points[1:3]) and piece.points[-1, 1] > 0.1 and peak < 1e6


def test_an_eraser_cuts_between_points_that_are_far_apart():
    line = Stroke(np.array([[100.0, 100], [400, 100]]), curve="nose", pressure=np.array([0, 1.0]))
    path = np.array([[180.0, 90], [180, 310]])
    left, right = rubbed(line, path, 10)
    for piece, ends in ((left, (100, 160)), (right, (200, 400))):
        assert np.abs(piece.points[[0, -1], 0] - ends).max() <= 10 and (piece.points[:, 1] == 100).all()
        np.testing.assert_allclose(piece.pressure, (piece.points[:, 0] - 100) / 300)
        assert piece.curve == "nose"
    assert rubbed(line, path + [300, 0], 10) == [line]


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("draw", {}),
        ("draw", {"points": []}),
        ("draw", {"points": [[1, 2, 3]]}),
        ("draw", {"points": [[1e9, 2]]}),
        ("draw", {"points": [[10**400, 2]]}),
        ("draw", {"points": [[1, True]]}),
        ("draw", {"points": [[1, 2]], "pressure": [0.5, 0.5]}),
        ("draw", {"points": [[1, 2]], "pressure": 1}),
        ("draw", {"points": [[1, 2]], "pressure": [2]}),
        ("draw", {"points": [[1, 2]], "pressure": [-0.5]}),
        ("draw", {"points": [[1, 2]], "width": 0}),
        ("draw", {"points": [[1, 2]], "colour": "red"}),
        ("erase", {"points": [[1, 2]]}),
        ("erase", {"points": [[1, 2]], "radius": 0}),
        ("clear", {"all": True}),
        ("follow", {"share": 2}),
        ("follow", {}),
        ("semantic", {}),
        ("semantic", {"strengths": {"Nose": 1}}),
        ("semantic", {"strengths": {"BigNose": 21}}),
        ("semantic", {"strengths": {"BigNose": "1"}}),
        ("semantic", {"strengths": {"BigNose": 1}, "keep": "BigMouth"}),
        ("semantic", {"strengths": {"BigNose": 1}, "keep": ["BigNose"]}),
        ("caricaturize", {"strength": -1}),
        ("caricaturize", {"strength": 1, "mode": "other"}),
        ("handle", {"handles": {}}),
        ("handle", {"handles": {"nose": [0, 0, 0.01]}}),
        ("handle", {"handles": {"nose_tip": [0, 0, 9]}}),
        ("handle", {"handles": {"nose_tip": [0, 0, 0]}}),
        ("handle", {"handles": {"99999": [0, 0, 0.01]}}),
        ("handle", {"handles": {"nose_tip": [0, 0, 0.01]}, "symmetric": 1}),
        ("expression", {"weights": {"jaw": 1}}),
        ("expression", {"weights": {"jawOpen": -0.5}}),
        ("expression", {"weights": {"jawOpen": 2}}),
        ("expression", {"weights": []}),
        ("dance", {}),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(start, tools, name, parameters):
    with pytest.raises(CaricliError) as error:
        operate(start, Operation(name, parameters), tools)
    assert "\n" not in str(error.value) and len(str(error.value)) < 600
    assert isinstance(error.value, InputError)


def test_what_goes_only_a_part_of_the_way_says_so(start, tools):
    far, near = (operate(start, _pulled(length), tools) for length in (0.1, 0.005))
    assert "% of the way" in far.remark and not near.remark


def _pulled(length):
    return Operation("handle", {"handles": {"nose_tip": [length, 0, 0]}})
