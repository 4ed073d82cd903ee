import json
import os
import subprocess
import sys

import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image
from tests.drawn_pictures import mean_shape, write_drawn_set

SETTINGS = ("epochs=2", "steps=2", "batch=6", "validate_every=1", "validation=2")
SMALL = ("--config", config_path("detector/tiny.yaml"), *(f"--set={text}" for text in SETTINGS))


@pytest.fixture(scope="module")
def pictures(head_template, tmp_path_factory):
    return write_drawn_set(tmp_path_factory.mktemp("drawn") / "set", mean_shape(head_template), 16, 0)


@pytest.fixture(scope="module")
def trained(run, pictures, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "detector", "--pictures", pictures, "--out", folder, *SMALL)
    assert result.exit_code == 0, result.output
    assert "epoch 2 of 2" in result.stderr and "faces found" in result.stdout
    return folder


def test_what_it_writes(trained, pictures):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train detector" and report["config"]["epochs"] == 2
    assert list(report["inputs"]) == [str(pictures / "pictures.json")]
    assert read_image(trained / "loss.png").std() > 0
    assert len((trained / "log.jsonl").read_text().splitlines()) == 2


def test_two_processes_train_together_and_one_of_them_speaks(pictures, tmp_path):
    torchrun = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2", "-m", "caricli"]
    folder = tmp_path / "run"
    command = [*torchrun, "train", "detector", "--pictures", pictures, "--out", folder, *SMALL]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("epoch 2 of 2") == 1 and done.stdout.count("faces found") == 1


def test_it_trains_on_several_folders_together(run, trained, pictures, head_template, tmp_path):
    more = write_drawn_set(tmp_path / "more", mean_shape(head_template), 8, 1)
    result = run(
        "train", "detector", "--pictures", pictures, "--pictures", more, "--start", trained / "model.safetensors",
        "--out", tmp_path / "run", *SMALL,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "run" / "model.json").read_text())
    sources = [folder / "pictures.json" for folder in (pictures, more)]
    assert list(report["inputs"]) == [*map(str, sources), str(trained / "model.safetensors")]


def test_what_it_reads_and_what_stands_there_is_kept(refused, trained, pictures, head_template, tmp_path):
    files = {path.name: path.read_bytes() for path in trained.iterdir()}
    start = trained / "model.safetensors"
    told = refused("train", "detector", "--pictures", pictures, "--start", start, "--out", trained, "--overwrite")
    assert f"{start}: expected an output, found one of the inputs" in told
    few = write_drawn_set(tmp_path / "few", mean_shape(head_template), 1, 0)
    told = refused("train", "detector", "--pictures", few, "--out", trained, "--overwrite")
    assert "to validate on" in told
    assert {path.name: path.read_bytes() for path in trained.iterdir()} == files


def test_other_settings_are_refused_and_what_is_no_folder_of_pictures(refused, trained, pictures, tmp_path):
    told = refused("train", "detector", "--pictures", pictures, "--out", trained, *SMALL, "--resume", "--set=seed=3")
    assert "seed 0 there, 3 here" in told
    told = refused("train", "detector", "--pictures", tmp_path, "--out", tmp_path / "run")
    assert "pictures.json" in told
