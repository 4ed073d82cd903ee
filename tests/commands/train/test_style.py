import json

import numpy as np
import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image, write_png
from caricli.methods.dynamic.styles import StyleBook
from caricli.store.styles import load_style, load_style_drawings

TINY = ("--config", config_path("style/tiny.yaml"))


@pytest.fixture(scope="module")
def drawings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawings")
    write_png(folder / "red.png", np.random.default_rng(0).integers(0, 256, (60, 50, 3), np.uint8))
    (folder / "torn.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    return folder


@pytest.fixture(scope="module")
def trained(run, drawings, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "style", "--drawings", drawings, "--out", folder, *TINY)
    assert result.exit_code == 0, result.output
    assert "% off, left as they are" in result.stdout
    assert "torn.png" in result.stderr and "epoch 3 of 3" in result.stderr
    return folder


def test_what_it_writes(trained, drawings):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train style" and list(report["inputs"]) == [str(drawings / "red.png")]
    assert report["validation"]["error"] > 0 and report["validation"]["kept"] > 0
    assert load_style(trained / "model.safetensors").model_id == report["model_id"]
    assert read_image(trained / "loss.png").std() > 0
    assert len((trained / "log.jsonl").read_text().splitlines()) == 3


def test_inspect_knows_it(run, trained):
    result = run("inspect", trained / "model.safetensors")
    assert result.exit_code == 0 and "style network" in result.stdout and "watercolour" in result.stdout


def test_its_network_lends_the_styles_of_a_folder(trained, drawings):
    pictures, notes = load_style_drawings(drawings)
    assert len(notes) == 1
    book = StyleBook(load_style(trained / "model.safetensors"), list(pictures.values()))
    generator = np.random.default_rng(0)
    styles = [style for style in (book.draw(generator) for _ in range(20)) if style.name == "drawing"]
    assert styles[0].paint(np.full((2, 32, 32, 3), 90, np.uint8)).shape == (2, 32, 32, 3)


def test_it_goes_on_and_refuses_other_settings(run, refused, trained, drawings):
    before = (trained / "model.safetensors").read_bytes()
    result = run("train", "style", "--drawings", drawings, "--out", trained, *TINY, "--resume")
    assert result.exit_code == 0 and (trained / "model.safetensors").read_bytes() == before
    empty = drawings.parent
    assert "no picture in it" in refused("train", "style", "--drawings", empty, "--out", trained.parent / "new", *TINY)
    told = refused("train", "style", "--drawings", drawings, "--out", drawings, *TINY, "--overwrite")
    assert "found one of the inputs" in told
