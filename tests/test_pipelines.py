import html
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from PIL import Image

from caricli.io.face import read_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import read_json
from caricli.structures import Mesh

ROOT = Path(__file__).parents[1]
PATIENCE = 300

pytestmark = pytest.mark.slow


@pytest.fixture
def snakemake(tmp_path):
    """Start a pipeline's tiny profile with results in tmp_path / out; `caricli` and `python` are those of the tests."""
    shims = {"caricli": f'"{sys.executable}" -m caricli', "python": f'"{sys.executable}"'}
    (tmp_path / "bin").mkdir()
    for name, command in shims.items():
        shim = tmp_path / "bin" / name
        shim.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        shim.chmod(0o755)
    path = f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT)}

    def start(name, *options):
        pipeline = ROOT / "pipelines" / name
        where = ["--workflow-profile", pipeline / "profiles" / "tiny", "--directory", tmp_path / "out"]
        return subprocess.Popen(
            [sys.executable, "-m", "snakemake", "--snakefile", pipeline / "Snakefile", *where, *options],
            env=environment, cwd=tmp_path, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip

    return start


def ended(process, code=0):
    printed, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == code, printed
    return printed


def kill_once(process, path, how=signal.SIGKILL):
    """Kill the workflow as soon as there is a file; what it printed."""
    deadline = time.monotonic() + PATIENCE
    while not path.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(process.pid, how)
    printed, _ = process.communicate()
    assert path.exists(), printed
    return printed


def links_of(page):
    """The links of a page without what follows a #, all of which lead to files beside it."""
    links = [unquote(html.unescape(link)) for link in re.findall(r'(?:href|src)="([^"#]+)', page.read_text("utf-8"))]
    wrong = [link for link in links if Path(link).is_absolute() or ":" in link or not (page.parent / link).is_file()]
    assert wrong == []
    return links


def test_deformable_goes_on_where_it_was_killed(snakemake, tmp_path):
    out = tmp_path / "out"
    log = out / "training" / "log.jsonl"
    kill_once(snakemake("deformable"), log)
    epochs, manifest = log.read_text(), (out / "dataset" / "dataset.json").stat()
    assert not (out / "models" / "deformable.safetensors").exists()

    ended(snakemake("deformable", "--unlock"))
    ended(snakemake("deformable"))
    assert (out / "dataset" / "dataset.json").stat() == manifest
    assert log.read_text().startswith(epochs)
    assert "Nothing to be done" in ended(snakemake("deformable"))

    page = (out / "index.html").read_text()
    assert len(links_of(out / "index.html")) > 10
    errors = read_json(out / "evaluation" / "shape.json")["models"]
    for kind in ("pca", "deformable"):
        assert f"<td>{errors[f'models/{kind}.safetensors']['test']['percent']:.3f}</td>" in page
        identity = read_json(out / "models" / f"{kind}.json")["model_id"]
        assert read_face(out / "astronaut" / f"{kind}.npz").model_id == identity


def test_sketch_goes_from_nothing_to_its_page(snakemake, tmp_path):
    out = tmp_path / "out"
    ended(snakemake("sketch"))
    assert "Nothing to be done" in ended(snakemake("sketch"))
    page = (out / "index.html").read_text("utf-8")
    assert {"drawn/face.obj", "drawn/lines.png", "evaluation/gallery.png"} < set(links_of(out / "index.html"))
    report = read_json(out / "evaluation" / "sketch.json")
    for errors in report["millimetres"].values():
        assert f"<td>{errors['noise']:.2f}</td>" in page
    assert read_json(out / "drawn" / "face.json")["coarse"] == "network"
    assert read_json(out / "sketches" / "sketches.json")["schema"] == "caricli.sketches/1"


def test_portrait_goes_on_where_it_was_killed_and_past_a_bad_picture(snakemake, tmp_path):
    pictures, out, good = tmp_path / "pictures", tmp_path / "out", "a & 'b' 1"
    pictures.mkdir()
    example = ROOT / "examples" / "astronaut"
    subprocess.run([sys.executable, example / "fetch_image.py", pictures / f"{good}.png"], check=True)
    shutil.copyfile(example / "landmarks.json", pictures / f"{good}.json")
    (pictures / "unmarked.png").write_bytes(b"no picture")
    start = ("portrait", "--config", "size=128", f"pictures={pictures}")

    head = out / "heads" / good
    kill_once(snakemake(*start), head / "refined.json")
    face = (head / "face.npz").stat()
    assert not (head / "rig.glb").exists() and not (out / "index.html").exists()
    ended(snakemake(*start, "--unlock"))

    ended(snakemake(*start), code=1)
    assert (head / "face.npz").stat() == face
    rig = read_gltf(head / "rig.glb")
    assert len(rig.names) == 52 and rig.pictures.skin.shape == (128, 128, 3)
    page = (out / "index.html").read_text("utf-8")
    assert "1 of 2 finished" in page and "a &amp; &#x27;b&#x27; 1" in page
    assert re.search(r'class="failed">detect failed: [^<]*unmarked\.png: expected', page)
    assert f"<td>{read_json(head / 'refined.json')['after']['all']:.3f}</td>" in page
    row = next(line for line in page.splitlines() if line.startswith('<tr><td><a href="#unmarked"'))
    assert re.search(r'<td class="failed">detect failed: ', row)
    assert (out / "thumbnails" / good / "rig.js").is_file() and page.count('class="turn"') == 1
    shown = {f"heads/{good}/{name}" for name in ("rig.glb", "rig.png", "textured/face.obj")}
    assert shown < set(links_of(out / "index.html"))

    (pictures / "unmarked.png").unlink()
    ended(snakemake(*start))
    assert (head / "face.npz").stat() == face and "unmarked" not in (out / "index.html").read_text("utf-8")
    assert "Nothing to be done" in ended(snakemake(*start))


def test_expressions_go_on_where_they_were_stopped_and_past_bad_files(snakemake, head, tmp_path):
    drawings, drivers, out, good = tmp_path / "drawings", tmp_path / "drivers", tmp_path / "out", "a & 'b' 1"
    drawings.mkdir()
    drivers.mkdir()
    example = ROOT / "examples" / "astronaut"
    subprocess.run([sys.executable, example / "fetch_image.py", drawings / f"{good}.png"], check=True)
    shutil.copyfile(example / "landmarks.json", drawings / f"{good}.json")
    (drawings / "unmarked.jpg").write_bytes(b"no picture")
    shutil.copyfile(example / "landmarks.json", drivers / "astronaut.json")
    (drivers / "bad.txt").write_text("1 2\n")
    neutral, moods = tmp_path / "neutral.obj", tmp_path / "moods.json"
    for path, actions in ((neutral, {}), (drivers / "open.obj", {"jawOpen": 0.7})):
        write_obj(path, Mesh(head.evaluate(weight=0.8, actions=actions), head.polygons))
    moods.write_text('{"neutral": {}, "jawOpen": {"jawOpen": 1}, "smile": {"mouthSmileLeft": 1, "mouthSmileRight": 1}}')
    folders = f"drawings={drawings}", f"drivers={drivers}"
    start = ("expressions", "--config", "size=128", *folders, f"neutral={neutral}", f"expressions={moods}")

    home = out / "heads" / good
    kill_once(snakemake(*start), home / "logs" / "texture.txt", signal.SIGTERM)
    face = (home / "refined.npz").stat()
    assert not (home / "textured").exists()

    ended(snakemake(*start), code=1)
    assert (home / "refined.npz").stat() == face
    blendshapes = read_gltf(home / "blendshapes.glb")
    assert blendshapes.names == ("jawOpen", "smile") and blendshapes.pictures.skin.shape == (128, 128, 3)
    weights = read_json(home / "expressions" / "open.json")["weights"]
    assert abs(weights["jawOpen"] - 0.7) < 0.02 and weights["smile"] < 0.02
    assert read_json(home / "expressions" / "astronaut.json")["weights"]["smile"] > 0.2
    page = (out / "index.html").read_text("utf-8")
    assert "2 of 6 expressions finished" in page and "a &amp; &#x27;b&#x27; 1" in page
    assert re.search(r'unmarked</b><p class="failed">detect failed: [^<]*unmarked\.jpg: expected', page)
    assert re.search(r'bad<p class="failed">driver failed: [^<]*bad\.txt: expected', page)
    shown = {f"heads/{good}/{name}" for name in ("blendshapes.glb", "blendshapes.png", "expressions/open.obj")}
    assert shown < set(links_of(out / "index.html"))
    small = out / "thumbnails" / "heads" / good
    rest, wide = (read_image(small / f"{name}.jpg") for name in ("neutral", "expressions/open"))
    assert rest.shape == (224, 224, 3) and wide.shape == (384, 384, 3)
    rest, wide = rest.astype(int), np.asarray(Image.fromarray(wide).resize((224, 224))).astype(int)
    changed = np.abs(rest - wide).max(2) > 30  # beyond what another size and its compression do
    assert changed[:112].sum() < changed[112:].sum() / 5

    # Landmarks without a picture, too, are a drawing.
    (drawings / "unmarked.jpg").unlink()
    shutil.copyfile(example / "landmarks.json", drawings / "unmarked.json")
    (drivers / "bad.txt").unlink()
    ended(snakemake(*start))
    page = (out / "index.html").read_text("utf-8")
    assert "4 of 4 expressions finished" in page and "failed:" not in page
    assert read_gltf(out / "heads" / "unmarked" / "blendshapes.glb").pictures.skin is None
    assert "heads/unmarked/expressions/open.obj" in links_of(out / "index.html")
    assert (home / "refined.npz").stat() == face
    assert "Nothing to be done" in ended(snakemake(*start))
