import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from caricli.io.face import read_face
from caricli.io.strict_json import read_json

ROOT = Path(__file__).parents[1]
PIPELINE = ROOT / "pipelines" / "deformable"
PATIENCE = 300


@pytest.fixture
def snakemake(tmp_path):
    """Start the tiny profile with results in tmp_path / out; `caricli` and `python` are those of the tests."""
    shims = {"caricli": f'"{sys.executable}" -m caricli', "python": f'"{sys.executable}"'}
    (tmp_path / "bin").mkdir()
    for name, command in shims.items():
        shim = tmp_path / "bin" / name
        shim.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        shim.chmod(0o755)
    path = f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT)}

    def start(*options):
        where = ["--workflow-profile", PIPELINE / "profiles" / "tiny", "--directory", tmp_path / "out"]
        return subprocess.Popen(
            [sys.executable, "-m", "snakemake", "--snakefile", PIPELINE / "Snakefile", *where, *options],
            env=environment, cwd=tmp_path, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip

    return start


def ended(process):
    printed, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, printed
    return printed


def test_deformable_goes_on_where_it_was_killed(snakemake, tmp_path):
    out, begun = tmp_path / "out", snakemake()
    log, deadline = out / "training" / "log.jsonl", time.monotonic() + PATIENCE
    while not log.exists() and begun.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(begun.pid, signal.SIGKILL)
    printed, _ = begun.communicate()
    assert log.exists(), printed
    epochs, manifest = log.read_text(), (out / "dataset" / "dataset.json").stat()
    assert not (out / "models" / "deformable.safetensors").exists()

    ended(snakemake("--unlock"))
    ended(snakemake())
    assert (out / "dataset" / "dataset.json").stat() == manifest
    assert log.read_text().startswith(epochs)
    assert "Nothing to be done" in ended(snakemake())

    page = (out / "index.html").read_text()
    links = re.findall(r'(?:href|src)="([^"]+)"', page)
    assert len(links) > 10
    assert [link for link in links if Path(link).is_absolute() or ":" in link or not (out / link).is_file()] == []
    errors = read_json(out / "evaluation" / "shape.json")["models"]
    for kind in ("pca", "deformable"):
        assert f"<td>{errors[f'models/{kind}.safetensors']['test']['percent']:.3f}</td>" in page
        identity = read_json(out / "models" / f"{kind}.json")["model_id"]
        assert read_face(out / "astronaut" / f"{kind}.npz").model_id == identity
