import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from caricli.io.checkpoint import read_checkpoint
from caricli.io.face import read_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj
from caricli.io.rig import read_rig
from caricli.io.strict_json import read_json
from caricli.io.takes.track import read_weights

ROOT = Path(__file__).parents[1]


@pytest.fixture
def run(tmp_path):
    """Run a script as a newcomer does, with `caricli` and `python` those of the tests."""
    shim = tmp_path / "bin" / "caricli"
    shim.parent.mkdir()
    shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m caricli "$@"\n')
    shim.chmod(0o755)
    path = f"{shim.parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHON": sys.executable, "PYTHONPATH": str(ROOT)}

    def run(script, *arguments):
        done = subprocess.run([script, *arguments], env=environment, capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


@pytest.mark.slow
def test_own_model(run, tmp_path):
    printed = run(ROOT / "examples" / "own_model" / "run.sh", tmp_path / "out")
    assert "components for 99 %" in printed and "test mm (%)" in printed
    face = read_face(tmp_path / "out" / "astronaut.npz")
    assert face.latent.shape == (12,) and face.residual.shape == (4200, 9)
    assert read_face(tmp_path / "out" / "latent.npz").residual is None
    assert read_image(tmp_path / "out" / "both.png").std() > 10
    assert read_checkpoint(tmp_path / "out" / "pca.safetensors")[1]["recipe"]["config"]["dimension"] == 8


@pytest.mark.slow
def test_second_topology(run, tmp_path):
    run(ROOT / "examples" / "second_topology" / "run.sh", tmp_path / "out")
    given = read_obj(tmp_path / "out" / "scans" / "scan_000.obj")
    written = read_obj(tmp_path / "out" / "astronaut.obj")
    assert (written.polygons == given.polygons).all() and (written.uv_polygons == given.uv_polygons).all()
    assert (written.uvs == given.uvs).all() and written.polygons.shape[1] == 4
    assert read_json(tmp_path / "out" / "astronaut.json")["nme"] < 1.5


def test_astronaut(run, tmp_path):
    example = ROOT / "examples" / "astronaut"
    run(sys.executable, example / "fetch_image.py", tmp_path / "astronaut.png")
    options = ["--image", tmp_path / "astronaut.png", "--out", tmp_path / "demo" / "astronaut.obj"]
    run("caricli", "reconstruct-from-landmarks", example / "landmarks.json", *options)
    names = sorted(path.name for path in (tmp_path / "demo").iterdir())
    assert names == ["astronaut.json", "astronaut.npz", "astronaut.obj", "astronaut.png"]
    figures = read_json(tmp_path / "demo" / "astronaut.json")
    assert figures["nme"] < 0.6 and figures["prior_rms"] < 1.0 and figures["flipped"] < 0.003


@pytest.mark.slow
def test_rig(run, tmp_path):
    run(ROOT / "examples" / "rig" / "run.sh", tmp_path / "out", "2.2", "64")
    track, rig = read_weights(tmp_path / "out" / "weights.json"), read_rig(tmp_path / "out" / "rig.npz")
    assert set(track.names) < set(rig.names) and track.weights.shape == (66, len(track.names))
    weights = dict(zip(track.names, track.weights.T, strict=True))
    assert weights["eyeBlinkLeft"].max() > 0.95 and (weights["mouthClose"] <= weights["jawOpen"]).all()
    assert weights["jawOpen"].max() > 0.1 and not track.weights[-1].any()
    moved, animation = read_gltf(tmp_path / "out" / "talk.glb"), read_json(tmp_path / "out" / "talk.json")
    assert moved.names == rig.names and animation["frames"] == 66 and animation["unmatched"] == []
    with Image.open(tmp_path / "out" / "preview.gif") as preview:
        assert preview.size == (64, 64) and preview.n_frames > 20


@pytest.mark.slow
def test_speech(run, tmp_path):
    printed = run(ROOT / "examples" / "speech" / "run.sh", tmp_path / "out", "48")
    assert "speech, 25 mouth cues, 3 s" in printed
    moved, animation = read_gltf(tmp_path / "out" / "speech.glb"), read_json(tmp_path / "out" / "speech.json")
    assert len(moved.names) == 52 and animation["frames"] == 181 and animation["unmatched"] == []
    assert animation["ranges"]["jawOpen"][1] > 0.4 and animation["ranges"]["mouthPucker"][1] > 0.4
    with Image.open(tmp_path / "out" / "speech.gif") as film:
        assert film.size == (48, 48) and film.n_frames > 50


@pytest.mark.slow
def test_drawing_to_rig(run, tmp_path):
    pictures, out = tmp_path / "pictures", tmp_path / "heads"
    pictures.mkdir()
    run(sys.executable, ROOT / "examples" / "astronaut" / "fetch_image.py", pictures / "astronaut.png")
    for name in ("astronaut", "bad"):
        shutil.copyfile(ROOT / "examples" / "astronaut" / "landmarks.json", pictures / f"{name}.json")
    (pictures / "bad.png").write_bytes(b"no picture")
    (pictures / "unmarked.png").touch()
    makefile = ROOT / "examples" / "drawing-to-rig" / "Makefile"
    with pytest.raises(AssertionError, match=r"(?s)bad\.png: expected|unmarked\.json"):
        run("make", "-j2", "-f", makefile, f"PICTURES={pictures}", f"OUT={out}", "SIZE=256", "DURATION=1")
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["astronaut"]
    rig, moved = read_gltf(out / "astronaut" / "rig.glb"), read_gltf(out / "astronaut" / "talk.glb")
    assert len(rig.names) == 52 and rig.pictures.skin.shape == (256, 256, 3) and rig.pictures.skin.std() > 10
    assert rig.pictures.eyes is not None and moved.names == rig.names
    errors = read_json(out / "astronaut" / "refined.json")
    assert errors["after"]["all"] < 0.05 < errors["before"]["all"]
    assert read_json(out / "astronaut" / "textured" / "face.json")["photometric_error"] < 0.06
