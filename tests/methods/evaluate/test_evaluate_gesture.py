from types import SimpleNamespace
from typing import Any

import numpy as np

from caricli.methods.evaluate.evaluate_gesture import DOUBTFUL, OTHER, GestureFigures, evaluate_gesture
from caricli.methods.evaluate.gesture_strangers import strange_gesture, strange_other
from caricli.store.gestures import load_gestures
from caricli.structures.gesture import GESTURES


def test_figures_as_by_hand():
    columns = (*GESTURES, DOUBTFUL)
    counts = {name: {key: 10 * (key == name) for key in columns} for name in GESTURES}
    counts[OTHER] = {key: 8 * (key == DOUBTFUL) for key in columns} | {"left_arrow": 2}
    counts["line"] |= {"line": 7, "left_arrow": 1, DOUBTFUL: 2}
    figures = GestureFigures(counts, 99.0)
    assert figures.right == 97 and figures.doubtful == 2 and np.isclose(figures.wrong_undo, 100 / 90)
    assert figures.other_doubtful == 80 and figures.other_undo == 20
    assert figures.as_json()["confusion"] is counts


def test_strangers_draw_each_by_its_seed():
    for name in GESTURES:
        first, again, other = (strange_gesture(name, np.random.default_rng([3, seed])) for seed in (0, 0, 1))
        assert np.array_equal(first, again) and not np.array_equal(first, other) and len(first) > 10
    assert all(len(strange_other(np.random.default_rng([4, seed]))) > 10 for seed in range(20))


def test_strokes_are_those_of_the_seed():
    seen = []

    def probabilities(strokes):
        seen.append(strokes)
        return np.eye(len(GESTURES))[[0] * len(strokes)]

    model: Any = SimpleNamespace(probabilities=probabilities)
    for seed in (7, 7, 8):
        figures = evaluate_gesture(model, 2, seed)
    assert figures.likeliest == 100 / len(GESTURES) and figures.counts[OTHER][GESTURES[0]] == 2
    first, again, other = (seen[k * (len(GESTURES) + 1)][0] for k in range(3))
    assert np.array_equal(first, again) and not np.array_equal(first, other)


def test_the_bundled_network_knows_hands_that_it_never_saw():
    figures = evaluate_gesture(load_gestures(), 40, seed=123)
    assert figures.likeliest > 95 and figures.wrong_undo <= 0.5 and figures.other_undo == 0
