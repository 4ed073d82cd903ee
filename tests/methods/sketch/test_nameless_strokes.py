from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.sketch.nameless_strokes import NamelessStrokes, rejoined
from caricli.methods.sketch.strokes_read import StrokesRead
from caricli.structures.sketch import Sketch, Stroke

LINE = np.column_stack([np.linspace(20, 220, 21), np.full(21, 80.0)])
SKETCH = Sketch((Stroke(LINE), Stroke(LINE + [0, 60])))


def read(sketch, whole):
    """The first stroke in two pieces."""
    first, second = sketch.strokes
    halves = (first.moved_to(LINE[:11]), first.moved_to(LINE[10:]))
    pieces = (replace(halves[0], curve="brow_left"), halves[1], replace(second, curve="nose"))
    chances = np.array([[0.9, 0.05], [0.0, 0.0], [0.14, 0.8]])
    return StrokesRead(sketch.with_strokes(pieces), chances, ("brow_left", "nose"))


def test_what_is_read_cuts_strokes_and_names_none():
    nameless = NamelessStrokes.of(SKETCH, read)
    assert [stroke.curve for stroke in nameless.sketch.strokes] == [None] * 3
    assert [stroke.curve for stroke in nameless.told.strokes] == ["brow_left", None, "nose"]
    assert nameless.numbers == [0, 1, 2]


def test_names_that_are_given_stay():
    first, second = SKETCH.strokes
    given = SKETCH.with_strokes((first, replace(second, curve="nose")))
    nameless = NamelessStrokes.of(given, read)
    assert [stroke.curve for stroke in nameless.sketch.strokes] == [None, None, "nose"] and nameless.numbers == [0, 1]


def test_what_is_unlikely_surprises():
    surprise = NamelessStrokes.of(SKETCH, read).surprise([("brow_left",), ("nose",), ("brow_left", "nose"), ("beard",)])
    assert surprise[0, 0] < 0 < surprise[0, 1] < surprise[1, 1]
    assert surprise[2, 0] == pytest.approx(0) and (surprise[:, 3] == 0).all()
    assert surprise[0, 2] == pytest.approx(np.log(0.14 / 0.95))
    assert surprise.min(1).sum() >= NamelessStrokes.of(SKETCH, read).most_likely < 0
    assert NamelessStrokes.of(SKETCH).most_likely == 0
    assert (NamelessStrokes.of(SKETCH).surprise([("nose",)]) == 0).all()


def test_irises_are_marked_and_the_lines_around_them_kept_before_anything_is_read():
    turn = np.linspace(0, 2 * np.pi, 60)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    eyes = [Stroke(circle * size + [x, 100]) for size in (20, 5) for x in (70, 180)]
    asked = []

    def keep(sketch, whole):
        asked.append(([str(stroke.kind) for stroke in sketch.strokes], list(whole)))
        return StrokesRead(sketch, np.zeros((4, 1)), ("nose",))

    nameless = NamelessStrokes.of(Sketch(tuple(eyes)), keep)
    assert asked == [(["unknown", "unknown", "wrinkle", "wrinkle"], [0, 1])]
    assert nameless.numbers == [0, 1] and nameless.eyes.all()


def test_without_a_network_nothing_is_cut():
    nameless = NamelessStrokes.of(SKETCH)
    assert nameless.sketch.strokes[0].points is LINE and nameless.read is None
    assert [stroke.curve for stroke in nameless.told.strokes] == [None, None]


def test_pieces_of_one_name_are_one_stroke_again():
    pieces = read(SKETCH, ()).sketch
    named = pieces.with_strokes(replace(stroke, curve="nose") for stroke in pieces.strokes)
    first, second = rejoined(named, SKETCH).strokes
    np.testing.assert_array_equal(first.points, LINE)
    assert first.curve == second.curve == "nose"
    assert len(rejoined(pieces, SKETCH).strokes) == 3
    # Strokes that were drawn so stay two.
    assert len(rejoined(named, named).strokes) == 3


def test_pieces_keep_the_pressure_of_their_stroke():
    pressure = np.linspace(0, 1, 21)
    halves = [Stroke(LINE[part], curve="nose", pressure=pressure[part]) for part in (slice(0, 11), slice(10, 21))]
    (whole,) = rejoined(Sketch(tuple(halves)), Sketch((Stroke(LINE, pressure=pressure),))).strokes
    np.testing.assert_array_equal(whole.pressure, pressure)
