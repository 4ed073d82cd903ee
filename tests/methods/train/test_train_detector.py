import copy

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.train_autodecoder import ALL, Share
from caricli.methods.train.train_detector import DetectorTraining
from caricli.models.detector.config import DetectorConfig
from tests.drawn_pictures import DrawnPictures, mean_shape

FEW = ("epochs=3", "steps=3", "batch=8", "crops=0.75", "validate_every=1", "validation=4")


def begin(pictures, *overrides, share=ALL):
    training, unseen = pictures
    config = read_config(config_path("detector/tiny.yaml"), DetectorConfig, overrides)
    return DetectorTraining(training, unseen, config, share)


@pytest.fixture(scope="module")
def pictures(head_template):
    shape = mean_shape(head_template)
    return DrawnPictures(shape, 40, 0), DrawnPictures(shape, 20, 1)


def test_it_learns_where_landmarks_are(pictures):
    training = begin(pictures)
    records = list(training.epochs())
    assert [record.epoch for record in records] == [1, 2, 3, 4]
    assert records[-1].loss < 0.7 * records[0].loss
    # All at the middle of the face would be 22 % off; the mean shape of so simple faces is 3 %.
    assert records[-1].validation_error < 0.05


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(pictures):
    whole = begin(pictures, *FEW)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    left = begin(pictures, *FEW)
    left.load_state(states[0])
    list(left.epochs())
    for name, value in left.average.state_dict().items():
        assert torch.equal(value, whole.average.state_dict()[name]), name
    assert left.state()["counters"] == states[-1]["counters"]


def test_the_state_of_another_training_is_refused(pictures):
    training = begin(pictures, *FEW)
    other = begin(pictures, *FEW, "width=8")
    with pytest.raises(InputError, match="network"):
        training.load_state(other.state())


def test_processes_share_the_windows_of_a_batch(pictures):
    whole = begin(pictures, *FEW)
    windows, crops = whole._draw(0)
    parts = [begin(pictures, *FEW, share=Share(process, 2))._draw(0) for process in (0, 1)]
    assert crops == 6 and [count for _, count in parts] == [3, 3]
    for number, window in enumerate(windows):
        own = parts[number % 2][0][number // 2]
        np.testing.assert_array_equal(own.pixels, window.pixels)


def test_pictures_without_faces_are_not_enough(head_template):
    shape = mean_shape(head_template)
    some = DrawnPictures(shape, 4, 0)
    none = DrawnPictures(shape, 0, 0)
    with pytest.raises(InputError, match="faces to validate on"):
        begin((some, none))
