import copy
from functools import partial

import pytest
import torch

from caricli.data.worker_pool import worker_pool
from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.detector.train_detector import DetectorTraining
from caricli.methods.train.processes import ALL, Share
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


@pytest.mark.slow
def test_it_learns_where_landmarks_are(pictures):
    training = begin(pictures)
    records = list(training.epochs())
    assert [record.epoch for record in records] == [1, 2, 3, 4]
    assert records[-1].loss < 0.7 * records[0].loss
    # All at the middle of the face would be 22 % off; the mean shape of so simple faces is 3 %.
    assert records[-1].validation_error < 0.05


@pytest.mark.parametrize("more", [(), ("steps=6", "rounds=3", "finer=1")], ids=["once", "again"])
def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(pictures, more):
    whole = begin(pictures, *FEW, *more)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    left = begin(pictures, *FEW, *more)
    left.load_state(states[0])
    list(left.epochs())
    for name, value in left.average.state_dict().items():
        assert torch.equal(value, whole.average.state_dict()[name]), name
    assert left.state()["counters"] == states[-1]["counters"]


def test_other_processes_draw_the_same_windows(pictures):
    few = (*FEW, "steps=4", "rounds=2")
    alone = begin(pictures, *few)
    helped = begin(pictures, *few)
    with worker_pool(2, partial(copy.copy, helped.windows)) as run:
        helped.draw_ahead(run)
        assert [record.loss for record in helped.epochs()] == [record.loss for record in alone.epochs()]


def test_rounds_that_do_not_fit_the_steps_are_refused():
    with pytest.raises(ValueError, match="steps must be a multiple of rounds, 2, found 3"):
        DetectorConfig(steps=3, rounds=2)


@pytest.mark.parametrize("crops", [0.1, 0.9])
def test_a_batch_without_faces_or_without_other_windows_is_refused(crops):
    with pytest.raises(ValueError, match=f"windows of both kinds in a batch of 4, found {crops}"):
        DetectorConfig(batch=4, crops=crops)


def test_the_state_of_another_training_is_refused(pictures):
    training = begin(pictures, *FEW)
    other = begin(pictures, *FEW, "width=8")
    with pytest.raises(InputError, match="network"):
        training.load_state(other.state())


def test_processes_share_the_windows_of_a_batch(pictures):
    whole = begin(pictures, *FEW)
    windows = whole._draw(0)
    parts = [begin(pictures, *FEW, share=Share(process, 2))._draw(0) for process in (0, 1)]
    assert len(windows.points) == 6 and [len(part.points) for part in parts] == [3, 3]
    for number, pixels in enumerate(windows.pixels):
        assert torch.equal(parts[number % 2].pixels[number // 2], pixels)


@pytest.mark.parametrize(
    ("crops", "words"),
    [(0.75, "one for each of 3 processes, found 2 other windows"), (0.25, "found 2 windows of one face")],
)
def test_a_batch_with_too_few_windows_of_a_kind_is_refused_by_every_process(pictures, crops, words):
    for process in range(3):
        with pytest.raises(InputError, match=words):
            begin(pictures, *FEW, f"crops={crops}", share=Share(process, 3))


def test_pictures_without_faces_are_not_enough(head_template):
    shape = mean_shape(head_template)
    some = DrawnPictures(shape, 4, 0)
    none = DrawnPictures(shape, 0, 0)
    with pytest.raises(InputError, match="faces to validate on"):
        begin((some, none))
