import json

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.gesture.model import (
    GestureModel,
    gesture_from_checkpoint,
    gesture_to_checkpoint,
    recognition,
)
from caricli.models.gesture.networks import GestureNetwork
from caricli.structures.gesture import GESTURES, roll_level

STROKE = np.array([[0.0, 0], [10, 3], [14, 20]])


@pytest.fixture(scope="module")
def model():
    return GestureModel(GestureNetwork(16, 1, len(GESTURES), torch.Generator().manual_seed(0)), {"seed": 0})


def test_where_and_how_large_a_stroke_is_does_not_matter(model):
    here, there = model.probabilities([STROKE, 8 * STROKE + [900, -40]])
    np.testing.assert_allclose(here, there, atol=1e-5)
    assert here.shape == (10,) and abs(here.sum() - 1) < 1e-5


def test_many_strokes_are_told_as_one_by_one(model):
    strokes = [STROKE * [1, 0.01 * k] for k in range(300)]
    together = model.probabilities(strokes)
    alone = [model.probabilities([each])[0] for each in (strokes[0], strokes[-1])]
    np.testing.assert_allclose(together[[0, -1]], alone, rtol=1e-5)
    assert model.probabilities([]).shape == (0, 10)


@pytest.mark.parametrize("stroke", [STROKE[:1], STROKE[:, :1], STROKE * np.nan, np.ones((5, 2))])
def test_what_is_no_line_is_refused(model, stroke):
    with pytest.raises(InputError, match="expected a stroke"):
        model.recognise(stroke)


def test_arrows_must_be_surer_than_others():
    def told(name, probability):
        chances = np.full(10, (1 - probability) / 9)
        chances[GESTURES.index(name)] = probability
        return recognition(chances)

    assert told("line", 0.8).name == "line" and told("left_arrow", 0.85).name is None
    assert told("left_arrow", 0.97).name == "left_arrow" and told("line", 0.3).name is None
    assert told("line", 0.3).likeliest == "line"


def test_levels_of_rolls():
    assert [roll_level(name) for name in GESTURES] == [0, 0, 0, 0, 1, 2, 3, -1, -2, -3]


def test_a_checkpoint_rebuilds_it(model):
    tensors, about = gesture_to_checkpoint(model)
    again = gesture_from_checkpoint(tensors, json.loads(json.dumps(about)), "it")
    assert again.recipe == {"seed": 0} and again.model_id == model.model_id
    np.testing.assert_allclose(again.probabilities([STROKE]), model.probabilities([STROKE]), atol=2e-3)


@pytest.mark.parametrize("change", [{"schema": "caricli.style/1"}, {"size": 20}, {"stride": "1"}, {"gestures": []}])
def test_what_does_not_fit_is_refused(model, change):
    tensors, about = gesture_to_checkpoint(model)
    with pytest.raises(InputError, match="^it: "):
        gesture_from_checkpoint(tensors, json.loads(json.dumps(about)) | change, "it")
