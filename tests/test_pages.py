"""The pages of workflows: what they show, and the viewer in a browser where there is one."""

import base64
import gzip
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.store.pictures import MARKS, PICTURES
from caricli.structures import Mesh, Rig

ROOT = Path(__file__).parents[1]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
NAME = "a & 'b' 1"


@pytest.fixture
def page(ball, tmp_path):
    """A page of two heads, the first of which stopped at its rig."""
    for name in ("2", NAME):
        head = tmp_path / "heads" / name
        (head / "textured").mkdir(parents=True)
        (head / "logs").mkdir()
        for file in ("face.npz", "refined.npz", "textured/face.npz"):
            (head / file).touch()
    (tmp_path / "heads" / "2" / "logs" / "rig.txt").write_text("caricli: error: face.npz: expected <less>\n")
    write_png(tmp_path / "heads" / NAME / "rig.png", np.full((1568, 2016, 3), 90, np.uint8))
    vertices, faces = ball
    rig = Rig(("jawOpen",), Mesh(vertices.astype(np.float32), faces), 0.1 * vertices[None].astype(np.float32))
    write_gltf(tmp_path / "heads" / NAME / "rig.glb", rig)
    write_png(tmp_path / "picture.png", np.full((90, 60, 3), 200, np.uint8))
    given = ("2", "picture.png", NAME, "picture.png")
    script = ROOT / "pipelines" / "portrait" / "gallery.py"
    subprocess.run([sys.executable, script, "index.html", *given], cwd=tmp_path, check=True)
    return tmp_path / "index.html"


def test_what_failed_says_why_in_the_table_and_at_the_head(page):
    text = page.read_text("utf-8")
    said = "rig failed: caricli: error: face.npz: expected &lt;less&gt;"
    row = next(line for line in text.splitlines() if line.startswith('<tr><td><a href="#2"'))
    assert f'<td class="failed">{said}</td>' in row and f'<p class="failed">{said}</p>' in text
    assert text.count("failed:") == 2 and "1 of 2 finished" in text


def test_sheets_are_large_enough_to_see(page):
    text = page.read_text("utf-8")
    width, height = re.search(r'alt="expressions" width="(\d+)" height="(\d+)"', text).groups()
    assert (int(width), int(height)) == (1600, 1244)


def test_a_head_to_turn_is_the_whole_glb_in_a_script(page):
    text = page.read_text("utf-8")
    assert text.count('class="turn"') == 1 and "http" not in text
    held = (page.parent / "thumbnails" / NAME / "rig.js").read_text("utf-8")
    path, packed = re.fullmatch(r'heads\[(".*")\] = (".*");\n', held).groups()
    assert f'data-head="{json.loads(path)}"' in text
    unpacked = gzip.decompress(base64.b64decode(json.loads(packed)))
    assert unpacked == (page.parent / "heads" / NAME / "rig.glb").read_bytes()
    beside = {path.name for path in (page.parent / "thumbnails" / "viewer").iterdir()}
    assert beside == {"LICENSE", "model-viewer-umd.min.js", "turntable.js"}


def seen(page, script, width=1200):
    """What Chromium makes of a page, from disk, in a window of a width, with a script at its end."""
    told = page.with_name("told.html")
    told.write_text(page.read_text("utf-8").replace("</html>", f"{script}</html>"), "utf-8")
    flags = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
    flags += ["--enable-unsafe-swiftshader", f"--user-data-dir={page.parent / 'profile'}", f"--window-size={width},900"]
    flags += ["--virtual-time-budget=15000", "--dump-dom"]
    return subprocess.run([CHROMIUM, *flags, told.as_uri()], capture_output=True, text=True, timeout=120)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_pictures_keep_their_shape_in_a_narrow_window_and_nothing_is_beside_it(page):
    script = """<script>onload = () => {
      const picture = document.querySelector('[alt="expressions"]');
      picture.loading = "eager";
      picture.decode().then(() => {
        document.title = "seen " + [picture.width, picture.height, document.documentElement.scrollWidth, innerWidth];
      });
    };</script>"""
    done = seen(page, script, 600)
    numbers = re.search(r"<title>seen ([\d,]+)", done.stdout)
    assert numbers, done.stdout[-500:] + done.stderr[-500:]
    width, height, whole, window = map(int, numbers[1].split(","))
    assert 300 < width < 600 and width / height == pytest.approx(1600 / 1244, rel=0.01)
    assert whole <= window


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_click_shows_it_from_disk(page):
    click = """<script>setTimeout(() => {
      document.querySelector("button.turn").click();
      const wait = setInterval(() => {
        const viewer = document.querySelector("model-viewer");
        if (viewer && viewer.loaded) { clearInterval(wait);
          document.title = "turns " + viewer.getDimensions().x;
          viewer.remove();
        }
      }, 200);
    }, 200);</script>"""
    done = seen(page, click)
    size = re.search(r"<title>turns ([\d.]+)", done.stdout)
    assert size and float(size[1]) == pytest.approx(2, abs=0.1), done.stdout[-500:] + done.stderr[-500:]


@pytest.fixture(scope="module")
def heads():
    """What heads.smk defines before it looks at any folder, by name."""
    text = (ROOT / "pipelines" / "common" / "heads.smk").read_text("utf-8")
    space = {"re": re, "sys": sys, "Path": Path}
    exec(re.search(r"def natural\(.*?\n\n\n(?=if )", text, re.S)[0], space)
    return space


def test_names_are_in_natural_order(heads):
    assert sorted(["10", "b2", "2", "B10", "1a", "b1"], key=heads["natural"]) == ["1a", "2", "10", "b1", "b2", "B10"]


@pytest.mark.parametrize("name", ["portrait", "expressions"])
def test_a_workflow_says_which_files_it_takes(name):
    text = (ROOT / "pipelines" / name / "README.md").read_text("utf-8")
    assert [kind for kind in PICTURES + MARKS if f"`{kind}`" not in text] == []


def test_of_files_of_one_name_the_first_kind_counts_or_they_are_refused(heads, tmp_path):
    for name in ("10.JPG", "2.png", "2.jpg", "2.txt", "._2.jpg", ".3.png"):
        (tmp_path / name).touch()
    kinds = (".png", ".jpg")
    assert list(heads["by_stem"](tmp_path, kinds).items()) == [("2", tmp_path / "2.png"), ("10", tmp_path / "10.JPG")]
    with pytest.raises(SystemExit) as refused:
        heads["by_stem"](tmp_path, kinds, alone=True)
    words = "expected pictures whose names differ before the suffix, found 2.png, too"
    assert str(refused.value) == f"{tmp_path / '2.jpg'}: {words}"
    (tmp_path / "2.jpg").unlink()
    assert list(heads["by_stem"](tmp_path, kinds, alone=True)) == ["2", "10"]
