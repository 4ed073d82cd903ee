import json

import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image
from caricli.store.gestures import load_gestures

TINY = ("--config", config_path("gesture/tiny.yaml"))


@pytest.fixture(scope="module")
def trained(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "gesture", "--out", folder, *TINY)
    assert result.exit_code == 0, result.output
    assert "% of further strokes told right" in result.stdout and "epoch 3 of 3" in result.stderr
    return folder


def test_what_it_writes(trained):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train gesture" and report["inputs"] == {} and report["config"]["seed"] == 0
    assert 0 <= report["validation"]["right"] <= 100
    assert load_gestures(trained / "model.safetensors").model_id == report["model_id"]
    assert read_image(trained / "loss.png").std() > 0
    assert len((trained / "log.jsonl").read_text().splitlines()) == 3


def test_inspect_knows_it(run, trained):
    result = run("inspect", trained / "model.safetensors")
    assert result.exit_code == 0 and "gesture network" in result.stdout and "left_arrow" in result.stdout


def test_it_goes_on_and_refuses_other_settings(run, refused, trained):
    before = (trained / "model.safetensors").read_bytes()
    result = run("train", "gesture", "--out", trained, *TINY, "--resume")
    assert result.exit_code == 0 and (trained / "model.safetensors").read_bytes() == before
    assert "steps 4 there, 5 here" in refused(
        "train", "gesture", "--out", trained, *TINY, "--set", "steps=5", "--resume"
    )


def test_an_input_is_no_output(refused, tmp_path):
    settings = tmp_path / "model.safetensors"
    settings.write_text("steps: 4\n")
    told = refused("train", "gesture", "--config", settings, "--out", tmp_path, "--overwrite")
    assert "found one of the inputs" in told and settings.read_text() == "steps: 4\n"


def test_evaluate_measures_it(run, trained, tmp_path):
    words = ("--network", trained / "model.safetensors", "--count", 3, "--out", tmp_path / "pen.json")
    result = run("evaluate", "gesture", *words)
    assert result.exit_code == 0, result.output
    assert "taken for undo" in result.stdout and "down_roll_1" in result.stdout
    report = json.loads((tmp_path / "pen.json").read_text())
    assert sum(report["confusion"]["no gesture"].values()) == 3 and len(report["confusion"]) == 11
