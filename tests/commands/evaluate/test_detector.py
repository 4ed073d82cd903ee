import json

import numpy as np
import pytest
import torch

from caricli.io.checkpoint import write_checkpoint
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.provenance import sha256_file
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.model import detector_to_checkpoint
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.structures.landmarks import Landmarks
from caricli.structures.parsing import Region
from tests.drawn_pictures import drawn_picture, mean_shape, write_drawn_set


@pytest.fixture(scope="module")
def pictures(head_template, tmp_path_factory):
    return write_drawn_set(tmp_path_factory.mktemp("drawn") / "set", mean_shape(head_template), 16, 0)


@pytest.fixture(scope="module")
def detector(pictures, tmp_path_factory):
    """Files of Detectors that have learnt nothing, one of whom says that it was trained on the pictures."""
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    folder = tmp_path_factory.mktemp("detector")
    recipe = {"inputs": {"set/pictures.json": sha256_file(pictures / "pictures.json")}}
    for name, own in (("stranger", None), ("pupil", recipe)):
        write_checkpoint(folder / f"{name}.safetensors", *detector_to_checkpoint(detector_of(network, 64, recipe=own)))
    return lambda name: folder / f"{name}.safetensors"


def test_generated_and_real_pictures_are_measured(run, pictures, detector, head_template, tmp_path):
    real = tmp_path / "real"
    real.mkdir()
    picture = drawn_picture(mean_shape(head_template), np.random.default_rng(0))
    write_png(real / "face.png", picture.pixels)
    write_landmarks(real / "face.txt", Landmarks(picture.landmarks[0][:68]))
    out = tmp_path / "figures"
    arguments = ("--pictures", pictures, "--real", real, "--detector", detector("stranger"), "--out", out)
    result = run("evaluate", "detector", *arguments)
    assert result.exit_code == 0, result.output
    figures = json.loads((out / "detector.json").read_text())
    assert figures["generated"]["pictures"] == 16 and figures["real"]["faces"] == 1
    assert figures["generated"]["recall"] == 0 and 0 < figures["generated"]["mean_shape"]["all"] < 5
    assert figures["real"]["iou"] == {} and "background" in figures["generated"]["iou"]
    assert "mean shape" in result.stdout and read_image(out / "detector.png").std() > 0


def test_whom_it_was_trained_with_is_left_out(run, pictures, detector, tmp_path):
    arguments = ("--pictures", pictures, "--detector", detector("pupil"), "--out", tmp_path / "figures")
    result = run("evaluate", "detector", *arguments)
    assert result.exit_code == 0 and "the detector has seen some of its people" in result.stderr
    figures = json.loads((tmp_path / "figures" / "detector.json").read_text())
    assert 0 < figures["generated"]["pictures"] < 8


def test_something_must_be_measured(run, detector, tmp_path):
    result = run("evaluate", "detector", "--detector", detector("pupil"), "--out", tmp_path / "figures")
    assert result.exit_code == 2 and "--pictures" in result.stderr
