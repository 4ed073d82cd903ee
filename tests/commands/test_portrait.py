"""Pictures to heads in one command: what is written, what is told, what is refused."""

import json
import re
from importlib import import_module

import click
import numpy as np
import pytest

from caricli.commands.shared.fit_tasks import COARSE_TASKS
from caricli.commands.shared.landmark_batch import LandmarkFiles
from caricli.commands.shared.portrait_chain import PortraitChain, PortraitFiles
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.strict_json import read_json
from caricli.methods.reconstruct.settings import COARSE
from caricli.methods.texture.settings import PaintSettings
from caricli.store.face_pictures import FaceReader
from caricli.structures import Camera, Landmarks, Pictures, Rig
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from tests.drawn_albedo import soft_skin
from tests.textured_pictures import render_textured

CAMERA = Camera(1050.0, np.diag([1.0, -1, -1]), np.array([150.0, 290.0]))
SIDE = 300
QUICK = ("--size", 64, "--parts", "skin")


@pytest.fixture(scope="module", autouse=True)
def quick(quick_pictures):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.commands.texture.SIZE", 48)
        patch.setattr("caricli.commands.shared.portrait_chain.SIZE", 64)
        patch.setattr(
            "caricli.commands.shared.portrait_chain.load_detector", lambda: type("None_", (), {"model_id": "none"})
        )
        yield


@pytest.fixture(scope="module")
def sitter(head, head_template):
    """A picture of a head, and its 81 landmarks."""
    vertices = head.evaluate(gender=0.3, age=0.6)
    skin = soft_skin(head_template)
    mesh = head_template.with_vertices(vertices.astype(np.float32))
    rig = Rig((), mesh, np.zeros((0, *vertices.shape), np.float32), pictures=Pictures(skin))
    picture = render_textured(rig, CAMERA.place(vertices), SIDE, SIDE, paper=np.array([60.0, 90, 160]))
    return picture, CAMERA.project(vertices[list(head_template.annotation.landmarks)])


@pytest.fixture(scope="module")
def heads(run, sitter, tmp_path_factory):
    """What comes of a picture of a doubtful face, of one whose landmarks are given, and of a broken one."""
    folder = tmp_path_factory.mktemp("portraits")
    picture, points = sitter
    for name in ("seen", "given"):
        write_png(folder / f"{name}.png", picture)
    (folder / "broken.png").write_bytes(b"no picture")
    (folder / "marks").mkdir()
    write_landmarks(folder / "marks" / "given.json", Landmarks(points[:68] + 1.0, (SIDE, SIDE)))

    def detect(pixels, detector, settings):
        spreads = np.tile(4 * np.eye(2), (81, 1, 1))
        marks = Landmarks(points, (SIDE, SIDE), spreads, np.ones(81))
        return Detection([DetectedFace(FaceFrame.of(points), 0.5, marks)], np.ones(pixels.shape[:2], np.uint8))

    with pytest.MonkeyPatch.context() as patch:
        # What imports it for the first time now would keep it.
        for name in ("see_face", "parse_face"):
            import_module(f"caricli.methods.detect.{name}")
        patch.setattr("caricli.methods.detect.detect_faces.detect_faces", detect)
        pictures = [folder / f"{name}.png" for name in ("seen", "broken", "given")]
        result = run("portrait", *pictures, "--landmarks", folder / "marks", *QUICK, "--out-dir", folder / "heads")
    return folder / "heads", result


def test_every_head_holds_what_the_single_commands_write(heads):
    out, result = heads
    assert result.exit_code == 1, result.output
    assert sorted(path.name for path in out.iterdir()) == ["given", "index.html", "seen", "thumbnails"]
    names = {path.name for path in (out / "seen").iterdir()}
    # The picture of the refinement shows the face before, too.
    four = ["refined.png", *(f"{stem}.{end}" for stem in ("face", "refined") for end in ("obj", "npz", "json"))]
    rig = [f"rig.{end}" for end in ("glb", "npz", "json", "png")]
    found = ["landmarks.json", "landmarks-overlay.png", "landmarks-regions.json", "landmarks-regions.png"]
    assert names == {*four, *rig, *found, "textured", "sheet.png", "portrait.json"}
    rigged = read_gltf(out / "seen" / "rig.glb")
    assert len(rigged.names) == 52 and rigged.pictures.skin.shape == (64, 64, 3)
    commands = {name: read_json(out / "seen" / f"{name}.json")["command"] for name in ("face", "refined", "rig")}
    assert commands == {"face": "reconstruct-from-landmarks", "refined": "refine", "rig": "rig"}
    assert read_json(out / "seen" / "refined.json")["after"]["all"] < 0.1


def test_no_file_names_where_it_was_staged(heads):
    out, _ = heads
    for path in out.rglob("*.json"):
        assert ".caricli-" not in path.read_text("utf-8"), path
    assert str(out / "seen" / "face.npz") in read_json(out / "seen" / "refined.json")["inputs"]
    for name in ("face", "textured/face"):
        assert str(out / "seen" / "landmarks-regions.png") in read_json(out / "seen" / f"{name}.json")["inputs"]


def test_given_landmarks_win(heads, sitter):
    out, _ = heads
    assert not (out / "given" / "landmarks-regions.png").exists()
    marks = read_landmarks(out / "given" / "landmarks.json")
    np.testing.assert_allclose(marks.points, sitter[1][:68] + 1.0, atol=1e-6)
    found = read_landmarks(out / "seen" / "landmarks.json")
    np.testing.assert_allclose(found.points, sitter[1], atol=1e-6)


def test_doubts_and_failures_are_told(heads):
    out, result = heads
    assert re.search(r"seen\.png: doubtful: its score is 0\.50", result.stderr)
    told = [line for line in result.stderr.splitlines() if "failed: " in line]
    assert (
        len(told) == 1 and re.search(r"failed: \S*broken\.png: expected a PNG", told[0]) and "1 of 3" in result.stderr
    )
    assert result.stdout.count("52 expressions") == 2
    page = (out / "index.html").read_text("utf-8")
    assert "2 of 3 finished" in page and page.count('class="turn"') == 2
    assert re.search(r'<td class="doubt">doubtful: its score is 0\.50', page)
    assert re.search(r'<td class="failed">[^<]*broken\.png: expected', page)
    for link in re.findall(r'(?:href|src)="([^"#]+)', page):
        assert (out / link).is_file(), link
    assert read_image(out / "seen" / "sheet.png").shape[1] > 7 * 64
    assert read_image(out / "thumbnails" / "seen" / "picture.jpg").shape == (SIDE, SIDE, 3)


def test_nothing_is_replaced_without_overwrite(heads, run, refused, tmp_path):
    out, _ = heads
    page = (out / "index.html").read_text("utf-8")
    told = refused("portrait", out.parent / "seen.png", "--out-dir", out)
    assert "seen exists; give --overwrite" in told
    pictures = [out.parent / f"{name}.png" for name in ("seen", "broken", "given")]
    again = run("portrait", *pictures, "--out-dir", out)
    assert again.exit_code == 1 and "3 of 3 failed" in again.stderr
    assert (out / "index.html").read_text("utf-8") == page
    (tmp_path / "index.html").write_text("mine")
    told = refused("portrait", out.parent / "seen.png", "--out-dir", tmp_path)
    assert "index.html exists; give --overwrite" in told
    (tmp_path / "thumbnails").mkdir()
    (tmp_path / "thumbnails" / "mine.txt").write_text("mine")
    told = refused("portrait", out.parent / "seen.png", "--out-dir", tmp_path, "--overwrite")
    assert "thumbnails: expected a folder with viewer/turntable.js to replace" in told


def test_a_picture_that_is_still_to_be_read_is_not_replaced(run, tmp_path):
    head = tmp_path / "heads" / "drawing"
    head.mkdir(parents=True)
    (head / "portrait.json").write_text("{}")
    paths = (tmp_path / "drawing.png", head / "styled.png")
    for path in paths:
        path.write_text("no picture")
    result = run("portrait", *paths, "--out-dir", tmp_path / "heads", "--overwrite")
    assert result.exit_code == 1 and "2 of 2 failed" in result.stderr
    assert f"expected an output, found a folder that holds the input {paths[1]}" in result.stderr
    assert paths[1].exists()


def test_wrong_usage(refused, heads, tmp_path):
    picture = heads[0].parent / "seen.png"
    assert "--out-dir" in refused("portrait", picture, code=2)
    marks = heads[0].parent / "marks" / "given.json"
    told = refused("portrait", picture, heads[0].parent / "given.png", "--landmarks", marks, "--out-dir", tmp_path)
    assert "expected a folder of landmarks" in told
    for name in ("thumbnails", "index.html"):
        told = refused("portrait", picture, tmp_path / f"{name}.jpg", "--out-dir", tmp_path)
        assert f"{name}.jpg: expected a name that is not the page's, found {name}\n" in told
    assert json.loads((heads[0] / "seen" / "portrait.json").read_text())["coarse"] == "elastic"


def test_a_caricature_is_made_first_where_a_style_is_given(tmp_path):
    files = PortraitFiles({tmp_path / "a.png": "a"}, tmp_path, None, 1, False)
    chain = PortraitChain(files, "ink", "elastic", PaintSettings())
    steps = chain._steps(tmp_path / "a.png", None, tmp_path / "a")
    first, taken, fit, *_ = steps
    assert chain.styling.settings.style == "ink" and first.args[1] == tmp_path / "a" / "styled.png"
    assert taken.args == (
        tmp_path / "a" / "styled.png",
        tmp_path / "a" / "styled.json",
        tmp_path / "a" / "landmarks.json",
    )
    assert fit.args[0].image == tmp_path / "a" / "styled.png" and fit.args[1] == taken.args[2]
    assert len(steps) == 7


@pytest.mark.parametrize(
    ("coarse", "command"),
    [("elastic", "reconstruct-from-landmarks"), ("network", "fit-coarse"), ("morphable", "fit-morphable")],
)
def test_heads_begin_as_they_are_told_to(sitter, tmp_path, coarse, command):
    picture, points = sitter
    write_png(tmp_path / "picture.png", picture)
    write_landmarks(tmp_path / "landmarks.json", Landmarks(points, (SIDE, SIDE)))
    files = PortraitFiles({}, tmp_path, None, 1, False)
    chain = PortraitChain(files, None, coarse, PaintSettings(64))
    given = LandmarkFiles((), tmp_path / "face.obj", None, tmp_path / "picture.png", FaceReader(), False)
    with click.Context(click.Command("portrait")):
        chain._fit(given, tmp_path / "landmarks.json")
    report = read_json(tmp_path / "face.json")
    assert report["command"] == command and report["nme"] < 5
    assert ("coefficients" in report) == (coarse == "network")


def test_every_beginning_is_offered():
    assert set(COARSE_TASKS) == set(COARSE)
