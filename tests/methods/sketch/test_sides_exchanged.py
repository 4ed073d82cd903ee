import numpy as np

from caricli.methods.sketch.sides_exchanged import sides_exchanged
from caricli.structures.sketch import Sketch, Stroke

PLACES = {
    "brow_left": (160, 80),
    "brow_right": (90, 80),
    "eye_upper_left": (155, 100),
    "eye_upper_right": (95, 100),
    "mouth_upper": (126, 180),
}
QUARTER = np.array([[0, -1], [1, 0]])


def sketch_of(names, turns=0):
    middle = np.array([128.0, 128])
    places = {
        name: (np.array(PLACES[at], float) - middle) @ np.linalg.matrix_power(QUARTER, turns) + middle
        for name, at in names.items()
    }
    strokes = [Stroke(place + [[-5.0, 0], [5, 0]], curve=name) for name, place in places.items()]
    return Sketch(tuple(strokes), (256, 256))


def exchanged(name):
    return name.replace("left", "x").replace("right", "left").replace("x", "right")


def test_sides_are_told_however_a_sketch_is_turned():
    for turns in range(4):
        assert not sides_exchanged(sketch_of({name: name for name in PLACES}, turns))
        assert sides_exchanged(sketch_of({exchanged(name): name for name in PLACES}, turns))


def test_one_pair_is_enough_and_none_says_nothing():
    brows = [name for name in PLACES if "brow" in name]
    assert sides_exchanged(sketch_of({exchanged(name): name for name in brows}))
    assert not sides_exchanged(sketch_of({name: name for name in brows}))
    assert not sides_exchanged(sketch_of({"brow_left": "brow_right", "mouth_upper": "mouth_upper"}))
    assert not sides_exchanged(Sketch((), (256, 256)))
