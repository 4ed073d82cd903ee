"""The page of docs/engines.md in a browser: three.js draws a rig, and its skin follows the weights."""

import json
import re
import shutil
import subprocess
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from threading import Thread
from urllib.parse import unquote

import numpy as np
import pytest

from caricli.io.gltf.write_gltf import write_gltf
from caricli.structures import Pictures, Rig
from caricli.structures.change_atlas import ChangeAtlas

ROOT = Path(__file__).parents[1]
THREE = ROOT / "tests" / "gltf_validator" / "node_modules" / "three"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PATIENCE = 300
"""Seconds that a busy machine may need to draw four frames."""

SIDE = 16
GREY = 100
RED = 60
"""Levels of 255 that the first expression adds to red."""

LOOK = """
renderer.setAnimationLoop(null);
function middle() {
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const pixel = new Uint8Array(4);
  gl.readPixels(gl.drawingBufferWidth / 2, gl.drawingBufferHeight / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  return [...pixel];
}
const seen = [];
for (const weights of [[0, 0], [1, 0], [0.5, 0], [0, 1]]) {
  setWeight("jawOpen", weights[0]);
  setWeight("browInnerUp", weights[1]);
  seen.push(middle());
}
await fetch("/seen?" + JSON.stringify(seen));
"""


def blocks(heading, language):
    """Blocks of code of a language below a heading of docs/engines.md."""
    text = (ROOT / "docs" / "engines.md").read_text("utf-8").split(f"\n{heading}\n", 1)[1]
    return re.findall(rf"```{language}\n(.*?)```", re.split(r"\n##+ ", text)[0], re.S)


@pytest.fixture
def rig(head_template):
    """A grey head; jawOpen makes its face redder, browInnerUp takes half of its colour."""
    tiles = np.full((2, 3, SIDE, SIDE, 3), 128, np.uint8)
    tiles[1, 0, ..., 0] = 255  # number 3, O of jawOpen
    tiles[1, 1] = 1  # number 4, G of browInnerUp
    picture = tiles.swapaxes(1, 2).reshape(2 * SIDE, 3 * SIDE, 3)
    changes = ChangeAtlas(picture, 3, SIDE, (0.0, 0.0, 1.0, 1.0), 0.5, RED / 255)
    deltas = np.zeros((2, *head_template.vertices.shape), np.float32)
    skin = Pictures(np.full((64, 64, 3), GREY, np.uint8))
    mesh = head_template.with_vertices(head_template.vertices.astype(np.float32))
    return Rig(("jawOpen", "browInnerUp"), mesh, deltas, pictures=skin, changes=changes)


class Listener(SimpleHTTPRequestHandler):
    """Serves a folder, and keeps what a page says it has seen."""

    def __init__(self, *given, told, **more):
        self.told = told
        super().__init__(*given, **more)

    def do_GET(self):
        """Answer."""
        path, _, said = self.path.partition("?")
        if path == "/seen":
            self.told.put(json.loads(unquote(said)))
        super().do_GET()


@pytest.fixture
def told():
    """What the page has seen."""
    return Queue()


@pytest.fixture
def site(tmp_path, told):
    """Address of a folder of the test with three.js in it."""
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    if not THREE.is_dir():
        pytest.skip("npm ci in tests/gltf_validator has not been run")
    (tmp_path / "three").symlink_to(THREE)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Listener, directory=tmp_path, told=told)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_the_skin_follows_the_weights(rig, site, told, tmp_path):
    write_gltf(tmp_path / "rig.glb", rig)
    (page,) = blocks("## three.js", "html")
    (follow,) = blocks("### A skin that follows the weights", "js")
    page = re.sub(r"https://cdn.jsdelivr.net/npm/three@[\d.]+/", "./three/", page)
    head, script = page.rsplit("</script>", 1)
    (tmp_path / "index.html").write_text(f"{head}{follow}{LOOK}</script>{script}", "utf-8")
    flags = [*FLAGS, f"--user-data-dir={tmp_path / 'profile'}", "--remote-debugging-port=0", "--window-size=400,400"]
    browser = subprocess.Popen([CHROMIUM, *flags, f"{site}/index.html"], stderr=subprocess.DEVNULL)
    try:
        seen = told.get(timeout=PATIENCE)
    finally:
        browser.kill()
        browser.wait()
    rest, red, half, dark = np.array(seen)[:, :3].astype(int)
    # Light and tone change a colour alike, whatever expression it is of.
    assert abs(rest - rest.mean()).max() <= 3 and rest.min() > 30
    assert red[0] > half[0] + 10 > rest[0] + 20 and abs(red - rest)[1:].max() <= 2
    assert (dark < rest - 20).all()
