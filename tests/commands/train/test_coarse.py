import json

import numpy as np
import pytest
import torch

from caricli.io.bundled import config_path
from caricli.io.checkpoint import write_checkpoint
from caricli.io.face import read_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import read_obj
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.model import detector_to_checkpoint
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.store.models import load_morphable
from caricli.structures import Landmarks
from caricli.structures.parsing import Region

SETTINGS = ("epochs=1", "steps=2", "batch=4", "painted=1", "unmarked=1", "validation=2")
SMALL = ("--config", config_path("coarse/tiny.yaml"), *(f"--set={text}" for text in SETTINGS))


@pytest.fixture(scope="module")
def detector(tmp_path_factory):
    path = tmp_path_factory.mktemp("seer") / "detector.safetensors"
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    write_checkpoint(path, *detector_to_checkpoint(detector_of(network, 64)))
    return path


@pytest.fixture(scope="module")
def pictures(run, dataset, tmp_path_factory):
    """What the command draws of the people of all splits."""
    out = tmp_path_factory.mktemp("pictures") / "pictures"
    result = run("dataset", "pictures", dataset, out, "--count", 72, "--size", 64, "--seed", 3, "--workers", 2)
    assert result.exit_code == 0, result.output
    return out


@pytest.fixture(scope="module")
def trained(run, dataset, pictures, detector, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    options = ("--data", dataset, "--pictures", pictures, "--detector", detector, "--out", folder)
    result = run("train", "coarse", *options, *SMALL)
    assert result.exit_code == 0, result.output
    assert "epoch 1 of 1" in result.stderr and "shape error" in result.stdout
    return folder


def test_what_it_writes(run, trained, dataset, pictures):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train coarse" and report["config"]["epochs"] == 1
    inputs = {str(dataset / "dataset.json"), str(pictures / "pictures.json"), "morphable model", "detector"}
    assert inputs < set(report["inputs"]) and report["people"]["train"]
    assert read_image(trained / "loss.png").std() > 0
    told = run("inspect", trained / "model.safetensors")
    assert "coarse network" in told.stdout and "239" in told.stdout


def test_other_pictures_are_refused(refused, dataset, detector, tmp_path):
    options = ("--data", dataset, "--detector", detector, "--out", tmp_path / "run", *SMALL)
    assert "expected a folder of `caricli dataset" in refused("train", "coarse", "--pictures", tmp_path, *options)


def test_as_many_datasets_as_folders_of_pictures(refused, dataset, pictures, detector, tmp_path):
    options = ("--pictures", pictures, "--detector", detector, "--out", tmp_path / "run", *SMALL)
    assert "expected one --data, or 1," in refused("train", "coarse", "--data", dataset, "--data", dataset, *options)


def test_an_input_is_no_output(refused, dataset, pictures, detector):
    options = ("--data", dataset, "--pictures", pictures, "--detector", detector, *SMALL, "--overwrite")
    for folder in (dataset, pictures):
        assert "found one of the inputs" in refused("train", "coarse", *options, "--out", folder)


def test_a_face_that_the_network_tells(run, refused, trained, points, tmp_path):
    marks = tmp_path / "marks.json"
    write_landmarks(marks, Landmarks(points[:68], (400, 400)))
    write_png(tmp_path / "face.png", np.random.default_rng(0).integers(0, 256, (400, 400, 3), np.uint8))
    common = ("fit-coarse", marks, "--network", trained / "model.safetensors")
    assert "marks.json: expected a picture, found landmarks without one" in refused(
        *common, "--out", tmp_path / "none.obj"
    )
    model = load_morphable()
    errors = {}
    for name, options in (("near", ()), ("alone", ("--alone",))):
        out = tmp_path / f"{name}.obj"
        result = run(*common, "--image", tmp_path / "face.png", "--out", out, *options)
        assert result.exit_code == 0, result.output
        report = json.loads(out.with_suffix(".json").read_text())
        face = read_face(out.with_suffix(".npz"))
        assert face.model_id == model.model_id and face.latent.shape == (144,)
        np.testing.assert_allclose(model.decode(face.latent), read_obj(out).vertices, atol=1e-5)
        counts = {part: len(values) for part, values in report["coefficients"].items()}
        assert counts == {"identity": 80, "expression": 64, "albedo": 80, "light": 9, "pose": 6}
        errors[name] = report["nme"]
        told = np.concatenate([report["coefficients"][part] for part in ("identity", "expression")])
        assert np.allclose(told, face.latent, atol=1e-5) == (name == "alone")
    assert errors["near"] < errors["alone"]
