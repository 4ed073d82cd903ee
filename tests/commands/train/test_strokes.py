import json
import shutil

import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image
from caricli.io.strict_json import read_json
from caricli.store.strokes import load_strokes

TINY = ("--config", config_path("strokes/tiny.yaml"))


@pytest.fixture(scope="module")
def trained(run, dataset, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "strokes", "--data", dataset, "--out", folder, *TINY)
    assert result.exit_code == 0, result.output
    assert "% of the places along further strokes misread" in result.stdout and "epoch 3 of 3" in result.stderr
    return folder


def test_what_it_writes(run, trained, dataset):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train strokes" and list(report["inputs"]) == [str(dataset / "dataset.json")]
    assert report["people"]["train"] and 0 < report["validation"]["misread"] <= 100
    assert load_strokes(trained / "model.safetensors").model_id == report["model_id"]
    assert read_image(trained / "loss.png").std() > 0
    told = run("inspect", trained / "model.safetensors")
    assert "stroke network" in told.stdout and "silhouette" in told.stdout


def test_resuming_ends_where_the_whole_does(run, trained, dataset, tmp_path):
    shutil.copytree(trained, tmp_path / "run")
    options = ("--data", dataset, "--out", tmp_path / "run", *TINY)
    assert run("train", "strokes", *options, "--resume").exit_code == 0
    assert run("train", "strokes", *options, "--overwrite").exit_code == 0
    assert (tmp_path / "run" / "model.safetensors").read_bytes() == (trained / "model.safetensors").read_bytes()


def test_a_folder_that_is_no_dataset_is_refused(refused, tmp_path):
    assert "dataset.json" in refused("train", "strokes", "--data", tmp_path, "--out", tmp_path / "run", *TINY)


def test_a_sketch_is_read_by_it(run, trained, tmp_path):
    drawn = tmp_path / "lines.svg"
    drawn.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="240" fill="none" stroke="black">'
        '<path d="M40 90 C30 220 170 220 160 90"/><path d="M60 90h30"/><path d="M110 90h30"/>'
        '<path d="M100 100v40"/><path d="M75 170h50"/></svg>'
    )
    words = ("--strokes", trained / "model.safetensors", "--out", tmp_path / "face.obj")
    result = run("reconstruct-from-sketch", drawn, *words)
    assert result.exit_code == 0, result.output
    assert str(words[1]) in read_json(tmp_path / "face.json")["inputs"]
