import numpy as np
import pytest

from caricli.io.bundled import config_path
from caricli.io.face import read_face
from caricli.io.strict_json import read_json
from caricli.store.models import load_model

TINY = ("--config", config_path("bilinear/tiny.yaml"))


@pytest.fixture(scope="module")
def trained(run, dataset, tmp_path_factory):
    path = tmp_path_factory.mktemp("bilinear") / "b.safetensors"
    result = run("train", "bilinear", "--data", dataset, "--out", path, *TINY)
    assert result.exit_code == 0, result.output
    return path


def test_a_model_is_written_that_rebuilds_itself_with_a_report(trained):
    model, report = load_model(trained), read_json(trained.with_suffix(".json"))
    assert model.kind == "bilinear" and report["model_id"] == model.model_id
    assert report["command"] == "train bilinear" and report["config"] == {"identity": 4, "expression": 3, "seed": 0}
    # Two people at two levels, with two expressions.
    assert len(model.prior.mean) == 4 + 2 - 1
    assert 0 < report["shape_error"]["train"]["percent"] < report["shape_error"]["test"]["percent"] < 10


def test_same_data_same_bytes(run, trained, dataset, tmp_path):
    out = tmp_path / "again.safetensors"
    assert run("train", "bilinear", "--data", dataset, "--out", out, *TINY).exit_code == 0
    assert out.read_bytes() == trained.read_bytes()


def test_landmarks_samples_and_measurements_take_it(run, trained, dataset, tmp_path):
    model = load_model(trained)
    shape = model.decode(model.prior.sample(np.random.default_rng(0), 1)[0])
    points = shape[model.template.annotation.landmarks[:68], :2] * [1500, -1500] + 500
    np.save(tmp_path / "marks.npy", points)
    out = tmp_path / "face.obj"
    result = run(
        "reconstruct-from-landmarks", tmp_path / "marks.npy", "--out", out, "--model", trained, "--method", "latent"
    )
    assert result.exit_code == 0, result.output
    assert read_face(out.with_suffix(".npz")).model_id == model.model_id
    assert run("evaluate", "shape", trained, "--data", dataset).exit_code == 0
    result = run("sample", "--model", trained, "--count", 1, "--out-dir", tmp_path / "faces")
    assert result.exit_code == 0, result.output
