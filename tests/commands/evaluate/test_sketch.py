import json

import pytest
import torch

from caricli.io.checkpoint import write_checkpoint
from caricli.io.image import read_image
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import SketchModel, sketch_to_checkpoint
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.store.models import load_model
from caricli.template.feature_curves import feature_curves


@pytest.fixture(scope="module")
def network(models, tmp_path_factory):
    """The file of a network for the small pca model that has learnt nothing."""
    model = load_model(models["pca"])
    names = tuple(curve.name for curve in feature_curves(model.template.annotation))
    size = SketchSize(4, (4, 4, 4), (0, 0, 0), 4, 4, 4)
    own = SketchNetwork(size, len(names), POINTS, len(model.prior.mean), torch.Generator().manual_seed(0))
    path = tmp_path_factory.mktemp("network") / "n.safetensors"
    write_checkpoint(path, *sketch_to_checkpoint(SketchModel(own, 64, names, model.model_id)))
    return path


def test_people_of_no_training_are_measured(run, dataset, models, network, tmp_path):
    options = ("--data", dataset, "--network", network, "--model", models["pca"], "--out", tmp_path / "out")
    result = run("evaluate", "sketch", *options)
    assert result.exit_code == 0, result.output
    assert "4 faces of 1 people" in result.stdout and "no word of whom" in result.stderr
    report = json.loads((tmp_path / "out" / "sketch.json").read_text())
    assert report["faces"] == 4 and report["test_people"] == {"unseen": 1, "of": 1}
    errors = report["millimetres"]
    assert errors["network"]["noise"] == pytest.approx(errors["mean face"]["noise"], rel=1e-3)
    for name in ("errors", "strokes", "gallery"):
        assert read_image(tmp_path / "out" / f"{name}.png").std() > 0


def test_nobody_is_measured_whom_the_model_was_trained_with(run, dataset, models, network, tmp_path):
    options = ("--data", dataset, "--network", network, "--model", models["pca"], "--out", tmp_path / "out")
    result = run("evaluate", "sketch", *options, "--everyone", "--count", 2)
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "out" / "sketch.json").read_text())
    assert report["faces"] == 2 and report["test_people"] == {"unseen": 1, "of": 3}


def test_a_network_of_another_model_is_refused(refused, dataset, network, tmp_path):
    said = refused("evaluate", "sketch", "--data", dataset, "--network", network, "--out", tmp_path / "out")
    assert "with the shape model" in said and not (tmp_path / "out").exists()


def test_held_out_faces_need_a_training_that_held_them_out(refused, dataset, models, network, tmp_path):
    options = ("--data", dataset, "--network", network, "--model", models["pca"], "--out", tmp_path / "out")
    assert "held the same faces out" in refused("evaluate", "sketch", *options, "--trained", dataset)
