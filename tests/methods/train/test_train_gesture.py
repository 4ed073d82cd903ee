import copy

import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.train_gesture import GestureTraining
from caricli.models.gesture.config import GestureConfig


def begin(*overrides, share=ALL):
    return GestureTraining(read_config(config_path("gesture/tiny.yaml"), GestureConfig, overrides), share)


def test_it_learns():
    records = list(begin("epochs=3", "steps=40", "batch=16", "learning_rate=3e-3", "size=32", "stride=2").epochs())
    assert records[-1].loss < 0.8 * records[0].loss
    assert records[-1].validation_error < records[0].validation_error


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes():
    whole = begin()
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    for number in (0, 1):
        left = begin()
        left.load_state(states[number])
        list(left.epochs())
        for name, value in left.average.state_dict().items():
            assert torch.equal(value, whole.average.state_dict()[name]), name


def test_what_is_no_gesture_may_be_any():
    drawn = begin("batch=200", "others=0.5")._draw(0)
    others = drawn.chances.amax(1) < 1
    assert 60 < others.sum() < 140 and torch.equal(drawn.chances[others], torch.full_like(drawn.chances[others], 0.1))
    assert drawn.ink.shape == (200, 1, 16, 16) and drawn.ink.amax() == 1


def test_a_batch_too_small_for_the_processes_is_refused():
    with pytest.raises(InputError, match="one for each of 3 processes, found 2"):
        begin("batch=2", share=Share(0, 3))


def test_processes_share_the_strokes_of_a_batch():
    whole = begin()._draw(0)
    parts = [begin(share=Share(process, 2))._draw(0) for process in (0, 1)]
    for number in range(4):
        assert torch.equal(parts[number % 2].ink[number // 2], whole.ink[number])
