import json
import shutil

import numpy as np
import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.store.sketch_networks import load_sketch_network, load_sketch_pair
from caricli.template.feature_curves import feature_curves

SMALL = ("--config", config_path("sketch/tiny.yaml"), "--set", "epochs=2", "--set", "steps=2")


@pytest.fixture(scope="module")
def trained(run, dataset, models, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    options = ("--data", dataset, "--model", models["pca"], "--out", folder)
    result = run("train", "sketch", *options, *SMALL)
    assert result.exit_code == 0, result.output
    assert "epoch 2 of 2" in result.stderr and "mm" in result.stdout
    return folder


def test_what_it_writes(run, trained, dataset, models):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train sketch" and report["config"]["epochs"] == 2
    assert set(report["inputs"]) == {str(dataset / "dataset.json"), str(models["pca"])} and report["people"]["train"]
    assert report["model_id"] == load_sketch_network(trained / "model.safetensors").model_id
    assert 0 < report["validation"]["percent"] < 20
    assert read_image(trained / "loss.png").std() > 0
    told = run("inspect", trained / "model.safetensors")
    assert "sketch network" in told.stdout and "silhouette" in told.stdout


def test_it_sees_the_face_of_a_sketch(trained, models):
    network, basis = load_sketch_pair(trained / "model.safetensors", models["pca"])
    curves = feature_curves(basis.template.annotation)
    camera = canvas_camera(basis.template.vertices, curves)
    face = see_sketch(draw_sketch(basis.template.vertices, curves, camera), network, basis)
    assert face.model_id == basis.model_id and np.isfinite(face.vertices).all()
    landmarks = basis.template.annotation.landmarks
    there = [camera.project(basis.template.vertices[landmarks])]
    there.append(face.require_camera().project(face.vertices[landmarks]))
    assert np.linalg.norm(there[0] - there[1], axis=1).mean() < 0.2 * 256


def test_more_data_and_resuming_end_where_the_whole_does(run, trained, dataset, models, tmp_path):
    options = ("--data", dataset, "--model", models["pca"], "--out", tmp_path / "run", *SMALL)
    assert run("train", "sketch", *options).exit_code == 0
    assert run("train", "sketch", *options, "--resume").exit_code == 0
    assert (tmp_path / "run" / "model.safetensors").read_bytes() == (trained / "model.safetensors").read_bytes()
    twice = ("--data", dataset, "--data", dataset, "--model", models["pca"], "--out", tmp_path / "two", *SMALL)
    assert run("train", "sketch", *twice).exit_code == 0


PUBLISHED = ("--config", config_path("sketch/tiny_published.yaml"), "--set", "steps=2", "--set", "held=0.4")


@pytest.fixture(scope="module")
def published(run, dataset, tmp_path_factory):
    """A published network, and the bilinear model whose u and v it tells."""
    folder = tmp_path_factory.mktemp("published")
    model = folder / "bilinear.safetensors"
    small = ("--set", "identity=4", "--set", "expression=2")
    assert run("train", "bilinear", "--data", dataset, "--out", model, *small).exit_code == 0
    result = run("train", "sketch", "--data", dataset, "--model", model, "--out", folder / "run", *PUBLISHED)
    assert result.exit_code == 0, result.output
    return folder / "run" / "model.safetensors", model


def test_a_published_network_is_told_by_its_variant(run, published):
    told = run("inspect", published[0])
    assert "sketch network" in told.stdout
    network, basis = load_sketch_pair(*published)
    assert network.label == "PixelShapeCNN" and network.held_out == (0.4, 0)
    assert len(network.curves) == len(feature_curves(basis.template.annotation))


def test_a_published_network_is_measured_under_both_protocols(run, published, dataset, tmp_path):
    network, model = published
    options = ("--data", dataset, "--trained", dataset, "--network", network, "--model", model)
    result = run("evaluate", "sketch", *options, "--count", 2, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "a random tenth" in result.stdout and result.stdout.count("PixelShapeCNN") == 2
    report = json.loads((tmp_path / "out" / "sketch.json").read_text())
    assert set(report["millimetres"]) == set(report["random_tenth"]["millimetres"]) >= {"PixelShapeCNN", "mean face"}
    assert report["faces"] == report["faces_held_out"] == 2


def test_faces_of_a_dataset_that_it_was_not_trained_with_are_no_random_tenth(refused, published, dataset, tmp_path):
    network, model = published
    shutil.copytree(dataset, tmp_path / "other")
    with open(tmp_path / "other" / "dataset.json", "a") as manifest:
        manifest.write("\n")
    options = ("--data", dataset, "--trained", tmp_path / "other", "--network", network, "--model", model)
    told = refused("evaluate", "sketch", *options, "--count", 2, "--out", tmp_path / "out")
    assert "other: expected a dataset that all networks were trained with, found another" in told


def test_a_published_network_needs_a_bilinear_model(refused, dataset, models, tmp_path):
    options = ("--data", dataset, "--out", tmp_path / "run", *PUBLISHED)
    assert "no --model" in refused("train", "sketch", *options)
    assert "train bilinear" in refused("train", "sketch", *options, "--model", models["pca"])
    assert "classify" in refused("train", "sketch", *options, "--set", "classify=4", code=2)


def test_bad_input_is_one_line(refused, dataset, models, tmp_path):
    out = tmp_path / "run"
    assert "linear model" in refused("train", "sketch", "--data", dataset, "--model", models["kernel"], "--out", out)
    assert "size" in refused("train", "sketch", "--data", dataset, "--out", out, "--set", "size=100", code=2)
    assert "missing" in refused("train", "sketch", "--data", tmp_path / "missing", "--out", out)
    assert not out.exists()
    told = refused("train", "sketch", "--data", dataset, "--out", dataset, "--overwrite")
    assert "found one of the inputs" in told


def test_a_network_of_another_model_is_refused(trained):
    from caricli.errors import InputError

    with pytest.raises(InputError, match="for the shape model"):
        load_sketch_pair(trained / "model.safetensors")
