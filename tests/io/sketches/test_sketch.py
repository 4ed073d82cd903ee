import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from caricli.errors import InputError
from caricli.io.sketches.sketch import read_sketch, write_sketch
from caricli.structures import Sketch, Stroke, StrokeKind

COORDINATE = st.floats(-1e4, 1e4).map(lambda x: round(x, 4))
POINTS = st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=6)
CURVES = st.none() | st.sampled_from(["nose", "brow_left", "Ö"])
STROKES = st.lists(st.builds(Stroke, POINTS, st.sampled_from(StrokeKind), CURVES), max_size=4)


@settings(max_examples=25, deadline=None)
@given(STROKES, st.integers(1, 500))
def test_json_keeps_everything(tmp_path_factory, strokes, width):
    path = tmp_path_factory.mktemp("sketch") / "s.json"
    write_sketch(path, Sketch(tuple(strokes), (width, 7)))
    back = read_sketch(path)
    assert back.size == (width, 7) and len(back.strokes) == len(strokes)
    for stroke, other in zip(strokes, back.strokes, strict=True):
        assert np.array_equal(stroke.points, other.points)
        assert (stroke.kind, stroke.curve, stroke.pressure, stroke.width) == (
            other.kind, other.curve, other.pressure, other.width,
        )  # fmt: skip


def test_pressure_and_width_are_kept(tmp_path):
    stroke = Stroke(np.eye(2), StrokeKind.UNKNOWN, None, np.array([0.25, 1]), 1.5)
    write_sketch(tmp_path / "s.json", Sketch((stroke,)))
    back = read_sketch(tmp_path / "s.json").strokes[0]
    assert back.pressure.tolist() == [0.25, 1] and back.width == 1.5


def good(**changes):
    value = {"schema": "caricli.sketch/1", "canvas": {"width": 9, "height": 8}, "strokes": []}
    return value | changes


def stroke(**changes):
    return good(strokes=[{"kind": "feature", "points": [[1, 2], [3, 4]]} | changes])


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([], "expected a sketch of the schema"),
        (good(schema="caricli.face/1"), "expected a sketch of the schema"),
        (good(more=1), "found 'more'"),
        (good(canvas={"width": 0, "height": 1}), "width: expected a whole number"),
        (good(canvas={"width": 9, "height": 1e9}), "height: expected a whole number"),
        (good(strokes={}), "strokes: expected list"),
        (good(strokes=[1]), "stroke 0: expected an object"),
        (stroke(kind="hair"), "stroke 0: expected the kind silhouette, feature"),
        (stroke(points=[]), "stroke 0: points: expected the shape"),
        (stroke(points=[[1, 2, 3]]), "stroke 0: points: expected pairs"),
        (stroke(points=[[1, True]]), "stroke 0: points: expected pairs"),
        (stroke(points=[[1, 1e300]]), "stroke 0: points: expected finite"),
        (stroke(curve=1), "stroke 0: curve: expected str"),
        (stroke(pressure=[0.1]), "stroke 0: pressure: expected the shape"),
        (stroke(pressure=[0.1, 2]), "stroke 0: pressure: expected finite"),
        (stroke(width="2"), "stroke 0: width: expected a number"),
        (stroke(colour="red"), "found 'colour'"),
    ],
    ids=str,
)
def test_what_is_no_sketch_is_refused(tmp_path, value, message):
    path = tmp_path / "s.json"
    path.write_text(json.dumps(value))
    with pytest.raises(InputError, match=message) as refusal:
        read_sketch(path)
    assert "\n" not in str(refusal.value)
