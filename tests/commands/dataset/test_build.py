import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import caricli
from caricli.data.dataset import read_dataset
from caricli.io.npz import read_npz
from caricli.io.provenance import sha256_file

ROOT = Path(caricli.__file__).parents[1]


def test_the_grid_is_built_and_read_again(dataset):
    data = read_dataset(dataset)
    assert data.vertices.shape == (16, 4200, 3)
    assert sorted(path.name for path in dataset.iterdir()) == [
        "dataset.json", "labels.npz", "shard-0000.npz", "template.npz",
    ]  # fmt: skip
    assert [path.name for path in dataset.parent.iterdir()] == ["dataset"]


def test_an_existing_dataset_is_replaced_only_when_told_to(run, refused, tmp_path):
    out = tmp_path / "d"
    sizes = ("--identities", 1, "--expressions", 1, "--levels", 1, "--workers", 1)
    out.mkdir()
    (out / "dataset.json").write_text("an old one")
    (out / "old.npz").write_text("a part of it")
    assert "--overwrite" in refused("dataset", "build", out, *sizes)
    assert (out / "dataset.json").read_text() == "an old one"
    assert run("dataset", "build", out, *sizes, "--overwrite").exit_code == 0
    assert len(read_dataset(out).vertices) == 1
    assert not (out / "old.npz").exists()


def test_random_colours_come_with_the_meshes(run, refused, tmp_path):
    sizes = ("--identities", 1, "--expressions", 1, "--levels", 1, "--workers", 1)
    for name in ("a", "b"):
        result = run("dataset", "build", tmp_path / name, *sizes, "--albedo", 3, "--albedo-size", 64)
        assert result.exit_code == 0, result.output
    file = tmp_path / "a" / "albedo.npz"
    assert file.read_bytes() == (tmp_path / "b" / "albedo.npz").read_bytes()
    pictures = read_npz(file)["albedo"]
    assert pictures.shape == (3, 64, 64, 3) and pictures.dtype == np.uint8
    data = read_dataset(tmp_path / "a")
    assert len(data.vertices) == 1
    entry = {"file": file.name, "count": 3, "size": 64, "seed": 0, "sha256": sha256_file(file)}
    assert data.manifest["albedo"] == entry
    said = refused("dataset", "build", tmp_path / "c", *sizes, "--albedo", 9000, "--albedo-size", 4096)
    assert "9000 albedos" in said and not (tmp_path / "c").exists()


def test_a_folder_of_someone_elses_is_not_replaced(refused, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    (tmp_path / "file").write_text("mine")
    assert "dataset.json" in refused("dataset", "build", tmp_path / "mine", "--overwrite")
    assert "folder" in refused("dataset", "build", tmp_path / "file", "--overwrite")
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "years of work"


@pytest.mark.parametrize(
    "options",
    [
        ["--count", 0],
        ["--levels", 5],
        ["--expressions", 26],
        ["--identities", 0],
        ["--seed", -1],
        ["--workers", 0],
        ["--own"],
        [],
    ],
)
def test_wrong_usage_is_2(run, tmp_path, options):
    result = run("dataset", "build", *([tmp_path / "d"] if options else []), *options)
    assert result.exit_code == 2 and result.stdout == ""
    assert list(tmp_path.iterdir()) == []


def workers_of(process):
    """Ids of the processes below a process that run Python's workers, from /proc."""
    found = []
    for task in Path(f"/proc/{process}/task").glob("*/children"):
        for child in task.read_text().split():
            try:
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(int(child))
            except OSError:
                continue
    return found


def seconds_of(process):
    """Processor time that a process has used."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
    return value


def start(out, *options):
    command = [sys.executable, "-m", "caricli", "dataset", "build", str(out), "--workers", "2", *options]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for workers in /proc")
@pytest.mark.parametrize(
    ("number", "used", "options"),
    [
        (signal.SIGTERM, 0.0, ["--count", "400"]),
        (signal.SIGTERM, 2.0, ["--identities", "50"]),
        (signal.SIGINT, 2.0, ["--count", "400"]),
    ],
)
def test_a_signal_leaves_nothing_behind_and_nobody_running(tmp_path, number, used, options):
    # Workers that have used no time are starting up, those that have used two seconds are making meshes.
    out = tmp_path / "deep" / "dataset"
    process = start(out, *options)
    try:
        workers = wait_for(lambda: len(w := workers_of(process.pid)) == 2 and w)
        wait_for(lambda: all(seconds_of(worker) >= used for worker in workers))
        assert (tmp_path / "deep").exists() and not out.exists()
        process.send_signal(number)
        stdout, stderr = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 128 + number
    assert stdout == ""
    assert stderr == f"caricli: error: stopped by {number.name}\n"
    assert list(tmp_path.iterdir()) == []
    wait_for(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers), 10)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for workers in /proc")
@pytest.mark.parametrize("used", [0.0, 2.0])
def test_workers_end_with_a_parent_that_was_killed(tmp_path, used):
    process = start(tmp_path / "dataset", "--count", "400")
    try:
        workers = wait_for(lambda: len(w := workers_of(process.pid)) == 2 and w)
        wait_for(lambda: all(seconds_of(worker) >= used for worker in workers))
    finally:
        process.kill()
    process.communicate(timeout=60)  # a worker that stays holds the pipes
    wait_for(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers), 10)
