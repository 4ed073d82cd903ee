import errno
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import torch

from caricli.io.bundled import config_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.face import write_face
from caricli.io.image import read_image
from caricli.io.training_state import read_state
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.checkpoint import model_from_checkpoint
from caricli.structures import Face, Mesh

SMALL = ("--set", "epochs=6", "--set", "validate_every=2")


@pytest.fixture(scope="module")
def tiny():
    return config_path("deformable/tiny.yaml")


@pytest.fixture(scope="module")
def trained(run, dataset, tiny, tmp_path_factory):
    """A finished training of six epochs."""
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "deformable", "--data", dataset, "--config", tiny, *SMALL, "--out", folder)
    assert result.exit_code == 0, result.output
    assert "validation" in result.stderr and "min left" in result.stderr
    assert result.stdout.startswith(f"{folder / 'model.safetensors'}: shape error")
    return folder


def test_what_it_writes(trained, head):
    recipe = json.loads((trained / "model.json").read_text())
    lines = [json.loads(line) for line in (trained / "log.jsonl").read_text().splitlines()]
    assert [line["epoch"] for line in lines] == [1, 2, 3, 4, 5, 6]
    assert [line["validation"] is None for line in lines] == [True, False] * 3
    assert recipe["epochs"] == 6 and set(recipe["shape_error"]) == {"validation", "test"}
    assert read_image(trained / "loss.png").std() > 0
    model = model_from_checkpoint(*read_checkpoint(trained / "model.safetensors"), "model")
    assert model.kind == "deformable" and model.model_id == recipe["model_id"]
    # The open head is deformed from a shape whose lips are apart.
    assert np.allclose(model.box.points, head.open_mouth_template().vertices)
    assert np.allclose(model.template.vertices, head.template().vertices)


def test_two_processes_train_as_one_and_one_of_them_speaks(trained, dataset, tiny, tmp_path):
    folder = tmp_path / "run"
    torchrun = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2", "-m", "caricli"]
    command = [*torchrun, "train", "deformable", "--data", dataset, "--config", tiny, *SMALL, "--out", folder]
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"}, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("epoch 6 of 6") == 1 and done.stdout.count("shape error") == 1
    logs = [(path / "log.jsonl").read_text().splitlines() for path in (folder, trained)]
    for mine, alone in zip(*logs, strict=True):
        assert json.loads(mine)["loss"] == pytest.approx(json.loads(alone)["loss"], rel=1e-2)


def test_resuming_what_has_ended_completes_it_and_changes_nothing(run, trained, dataset, tiny, tmp_path):
    folder = shutil.copytree(trained, tmp_path / "run")
    lines = (folder / "log.jsonl").read_text().splitlines(keepends=True)
    (folder / "log.jsonl").write_text("".join(lines[:-1]))  # killed after its last state
    (folder / "loss.png").unlink()
    result = run("train", "deformable", "--data", dataset, "--config", tiny, *SMALL, "--out", folder, "--resume")
    assert result.exit_code == 0, result.output
    for name in ("model.safetensors", "log.jsonl", "loss.png"):
        assert (folder / name).read_bytes() == (trained / name).read_bytes(), name


def test_a_folder_that_cannot_be_written_is_refused_before_it_trains(refused, dataset, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    def train(*_, **__):
        raise AssertionError("nothing must be trained")

    monkeypatch.setattr("caricli.methods.train.deformable.train_deformable.train_deformable", train)
    (tmp_path / "link").symlink_to("link")
    args = ("train", "deformable", "--data", dataset, "--out")
    assert "link: " in refused(*args, tmp_path / "link")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "model.safetensors").symlink_to("model.safetensors")
    assert "model.safetensors" in refused(*args, tmp_path / "run", "--overwrite")
    monkeypatch.setattr("caricli.io.outputs.tempfile.mkdtemp", refuse)
    assert "cannot be written: Permission denied" in refused(*args, tmp_path / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "run"]


def test_an_existing_run_is_kept(refused, trained, dataset, tiny):
    line = refused("train", "deformable", "--data", dataset, "--config", tiny, "--out", trained)
    assert "--resume" in line and "--overwrite" in line
    line = refused("train", "deformable", "--data", dataset, "--config", tiny, "--out", dataset, "--overwrite")
    assert "found one of the inputs" in line


def test_other_settings_cannot_go_on(refused, trained, dataset, tiny):
    args = ("--config", tiny, *SMALL, "--set", "seed=3", "--out", trained, "--resume")
    assert "another" in refused("train", "deformable", "--data", dataset, *args)


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b"PK" + b[2:][::-1]])
def test_a_damaged_state_is_refused(refused, trained, dataset, tiny, tmp_path, damage):
    folder = shutil.copytree(trained, tmp_path / "run")
    state = folder / "state.pt"
    state.write_bytes(damage(state.read_bytes()))
    args = ("--config", tiny, *SMALL, "--out", folder, "--resume")
    assert "state.pt" in refused("train", "deformable", "--data", dataset, *args)


@pytest.mark.parametrize("setting", ["depth=3", "width=0", "latent=many", "precision=int8", "points"])
def test_bad_settings_are_refused_and_nothing_is_written(refused, dataset, tmp_path, setting):
    refused("train", "deformable", "--data", dataset, "--set", setting, "--out", tmp_path / "run", code=2)
    assert not (tmp_path / "run").exists()


def test_cuda_that_is_not_there_is_refused(refused, dataset, tmp_path, monkeypatch):
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    line = refused("train", "deformable", "--data", dataset, "--device", "cuda", "--out", tmp_path / "run")
    assert "CUDA" in line
    assert not (tmp_path / "run").exists()


def test_a_pipe_as_template_is_not_waited_for(refused, dataset, tmp_path):
    os.mkfifo(tmp_path / "pipe.obj")
    options = ("--data", dataset, "--out", tmp_path / "out", "--template", tmp_path / "pipe.obj")
    assert "pipe.obj: expected a file, found something that is not a regular file" in refused(
        "train", "deformable", *options
    )


def test_a_template_of_another_topology_is_refused(refused, dataset, ball, tmp_path):
    write_face(tmp_path / "ball.npz", Face(Mesh(*ball)))
    args = ("--template", tmp_path / "ball.npz", "--out", tmp_path / "run")
    assert "topology" in refused("train", "deformable", "--data", dataset, *args)


def test_a_loss_that_explodes_keeps_the_last_good_checkpoint(run, trained, dataset, tiny, tmp_path, monkeypatch):
    folder = tmp_path / "run"
    args = ("train", "deformable", "--data", dataset, "--config", tiny, *SMALL, "--out", folder)
    usual = AutoDecoderTraining._loss

    def exploding(training, rows, generator):
        loss, distance = usual(training, rows, generator)
        return loss * (1 if training.epoch < 3 else torch.inf), distance

    with monkeypatch.context() as patch:
        patch.setattr(AutoDecoderTraining, "_loss", exploding)
        result = run(*args)
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1].startswith("caricli: error: the loss of epoch 4 is not finite")
    assert read_state(folder / "state.pt")[0]["counters"][0] == 3
    assert [json.loads(line)["epoch"] for line in (folder / "log.jsonl").read_text().splitlines()] == [1, 2, 3]
    # The best model so far is that of the validation after epoch 2.
    model = model_from_checkpoint(*read_checkpoint(folder / "model.safetensors"), "model")
    assert model.kind == "deformable" and not (folder / "model.json").exists()
    assert run(*args, "--resume").exit_code == 0
    assert (folder / "model.safetensors").read_bytes() == (trained / "model.safetensors").read_bytes()


def test_killed_at_random_moments_it_ends_in_the_same_bytes(dataset, tiny, tmp_path):
    """SIGKILL thrice, resumed every time, against a run that was left alone."""
    chance = random.Random(0)

    def start(folder):
        command = [sys.executable, "-m", "caricli", "train", "deformable", "--data", dataset, "--config", tiny]
        command += ["--set", "epochs=60", "--out", folder, "--resume"]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)

    def epochs(folder):
        log = folder / "log.jsonl"
        return len(log.read_text().splitlines()) if log.exists() else 0

    alone, killed = tmp_path / "alone", tmp_path / "killed"
    assert start(alone).wait() == 0
    for third in (5, 20, 35):
        process = start(killed)
        while epochs(killed) < third + chance.randrange(15) and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.1 * chance.random())
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        assert epochs(killed) < 60
    assert start(killed).wait() == 0
    assert epochs(killed) == 60
    for name in ("model.safetensors", "log.jsonl", "loss.png"):
        assert (killed / name).read_bytes() == (alone / name).read_bytes(), name
    reports = [json.loads((folder / "model.json").read_text()) for folder in (killed, alone)]
    assert reports[0] | {"seconds": 0} == reports[1] | {"seconds": 0}
