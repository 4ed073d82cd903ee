"""Detectors and pictures for all tests of detection."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch

from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.detector.train_detector import DetectorTraining
from caricli.methods.train.detector.windows import WindowSettings
from caricli.models.detector.config import DetectorConfig, DetectorSize
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.structures.parsing import Region
from tests.drawn_pictures import DrawnPictures, mean_shape


@pytest.fixture(scope="session")
def untrained():
    """A Detector with random weights: where it says landmarks are depends on the window alone."""
    generator = torch.Generator().manual_seed(0)
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), generator)
    for parameter in network.parameters():
        if not parameter.any():
            torch.nn.init.uniform_(parameter, 0, 0.5, generator)
    network.heat.weight.data *= 100
    return detector_of(network, 64)


@pytest.fixture(scope="session")
def lesson(head_template):
    """A training on simple drawn faces as they are, for seconds; its record; and pictures that it has not seen."""
    shape = mean_shape(head_template)
    unseen = DrawnPictures(shape, 20, 1)
    settings = ["epochs=1", "steps=300", "validate_every=1", "validation=4", "learning_rate=0.005", "crops=0.6"]
    settings += ["parsing_weight=0.7"]  # in so few steps faces must not come after regions
    config = read_config(config_path("detector/tiny.yaml"), DetectorConfig, settings)
    training = DetectorTraining(DrawnPictures(shape, 80, 0), unseen, config)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.methods.train.detector.window_batch.disguise_window", as_it_is)
        patch.setattr("caricli.methods.train.detector.windows.distort_picture", lambda picture, *_: picture)
        varied = partial(WindowSettings, turn=0.2, bent=0.25, cut=0.15)  # there are so few pictures
        patch.setattr("caricli.methods.train.detector.window_batch.WindowSettings", varied)
        (record,) = training.epochs()
    return training, record, unseen


@pytest.fixture(scope="session")
def trained(lesson):
    """A Detector of a short training, and pictures that it was not trained on."""
    training, _, unseen = lesson
    return detector_of(training.average, 64), unseen


def as_it_is(window, generator):
    return replace(window, pixels=window.pixels.astype(np.float32) / 255)
