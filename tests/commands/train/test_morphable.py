import shutil

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.io.bundled import config_path
from caricli.io.face import read_face
from caricli.io.strict_json import read_json, write_json
from caricli.store.models import load_model

TINY = ("--config", config_path("morphable/tiny.yaml"))


@pytest.fixture(scope="module")
def trained(run, dataset, tmp_path_factory):
    path = tmp_path_factory.mktemp("morphable") / "m.safetensors"
    result = run("train", "morphable", "--data", dataset, "--out", path, *TINY)
    assert result.exit_code == 0, result.output
    return path


def test_a_model_is_written_that_rebuilds_itself_with_a_report(trained, dataset):
    model, report, data = load_model(trained), read_json(trained.with_suffix(".json")), read_dataset(dataset)
    assert model.kind == "morphable" and report["model_id"] == model.model_id
    assert report["command"] == "train morphable" and report["config"]["identity"] == 6
    # Two people with two expressions each, as they are, are what is trained on.
    assert 1 <= len(model.identity) < 4 and 1 <= len(model.expression) <= 4 and len(model.albedo.basis) == 5
    assert 0 < report["shape_error"]["train"]["percent"] < report["shape_error"]["test"]["percent"] < 10
    regular = report["agreement"]["test_regular"]
    assert regular["identity_of_an_expression"] is None or regular["identity_of_an_expression"] < 0.9
    rows = data.rows("train") & (data.level == 1)
    who, what = model.parts(model.encode(data.vertices[rows].astype(float)))
    neutral = data.expression[rows] == 0
    assert np.abs(what[neutral]).mean() < 0.3 * np.abs(what[~neutral]).mean()


def test_exaggerated_meshes_are_trained_with_where_they_are_asked_for(run, refused, trained, dataset, tmp_path):
    out = tmp_path / "all.safetensors"
    options = ("--data", dataset, *TINY, "--set", "exaggerated=true")
    assert run("train", "morphable", "--out", out, *options).exit_code == 0
    assert len(load_model(out).identity) == 6 > len(load_model(trained).identity)
    copy = shutil.copytree(dataset, tmp_path / "copy")
    splits = {"train": [0], "validation": [1], "test": [2, 3]}
    write_json(copy / "dataset.json", read_json(copy / "dataset.json") | {"splits": splits})
    said = refused("train", "morphable", "--data", copy, "--out", tmp_path / "m.safetensors")
    assert "at least 3 meshes in the dataset's train split that are not exaggerated, found 2" in said


def test_same_data_same_bytes(run, trained, dataset, tmp_path):
    out = tmp_path / "again.safetensors"
    assert run("train", "morphable", "--data", dataset, "--out", out, *TINY).exit_code == 0
    assert out.read_bytes() == trained.read_bytes()


def test_evaluate_and_sample_take_it(run, trained, dataset, tmp_path):
    assert run("evaluate", "shape", trained, "--data", dataset, "--out", tmp_path / "e.json").exit_code == 0
    (errors,) = read_json(tmp_path / "e.json")["models"].values()
    assert 0 < errors["train"]["percent"] < 5
    result = run("sample", "--model", trained, "--count", 1, "--out-dir", tmp_path / "faces")
    assert result.exit_code == 0, result.output
    assert read_face(tmp_path / "faces" / "face-000.npz").model_id == load_model(trained).model_id


@pytest.mark.parametrize("setting", ["identity=0", "noise=0", "dimension=3", "albedo=many"])
def test_bad_settings_are_one_line_and_leave_nothing(refused, dataset, tmp_path, setting):
    out = tmp_path / "m.safetensors"
    said = refused("train", "morphable", "--data", dataset, "--out", out, "--set", setting, code=2)
    assert setting.split("=")[0] in said
    assert list(tmp_path.iterdir()) == []


def test_a_mesh_of_ones_own_without_expressions(run, eggs, tmp_path):
    folder, out = tmp_path / "d", tmp_path / "m.safetensors"
    result = run("dataset", "import", eggs, folder, "--annotation", eggs.parent / "annotation.json")
    assert result.exit_code == 0, result.output
    result = run("train", "morphable", "--data", folder, "--out", out)
    assert result.exit_code == 0, result.output
    assert len(load_model(out).expression) == 0 and load_model(out).colours(np.zeros(80)).shape[1] == 3
