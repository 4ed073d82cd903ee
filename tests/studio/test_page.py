"""The page in Chromium, played with a pointer as a person would."""

import json
import zipfile
from types import SimpleNamespace
from typing import Any
from urllib.parse import urljoin

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from caricli.cli import cli
from caricli.errors import InputError
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.meshes.mesh import write_mesh
from caricli.io.session import read_session
from caricli.structures import Operation, Pictures
from caricli.studio.page import Page
from tests.studio.conftest import PATIENCE, Server, Tab, run_apart

TURN = np.linspace(0, 2 * np.pi, 30)
OUTLINE = np.stack([256 + 150 * np.cos(TURN), 260 + 190 * np.sin(TURN)], axis=1).tolist()
EYES = [np.stack([x + 30 * np.cos(TURN), 230 + 12 * np.sin(TURN)], axis=1).tolist() for x in (195, 317)]
MOUTH = [[200, 375], [256, 392], [312, 375]]
MANY = """() => {
  const session = JSON.parse(localStorage.getItem(caricliKeep.name));
  const points = Array.from({length: 30000}, (_, k) => [200.25 + 0.001 * k, 200.125]);
  for (let k = 0; k < 2; k++) session.operations.push({name: "draw", parameters: {points}});
  localStorage.setItem(caricliKeep.name, JSON.stringify(session));
}"""
"""Long lines, as a tab that was closed may have kept them."""


def replayed(session, folder):
    """The OBJ that the command line makes of a session."""
    result = CliRunner().invoke(cli, ["studio", "--replay", str(session), "--out", str(folder / "replayed.obj")])
    assert result.exit_code == 0, result.output
    return (folder / "replayed.obj").read_bytes()


def faces(path):
    """OBJ, NPZ and session of a saved ZIP."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_a_face_is_drawn_changed_saved_and_replayed_to_the_same_bytes(tab, server, tmp_path):
    start = tab.head()
    heads = [start]
    for line in (OUTLINE, *EYES, MOUTH):
        tab.draw(line)
        heads.append(tab.head())
    assert all(np.abs(np.subtract(a, b)).max() > 1e-4 for a, b in zip(heads, heads[1:], strict=False))
    tab.page.get_by_role("button", name="Eraser").click()
    tab.draw([MOUTH[1]])
    assert not np.array_equal(tab.head(), heads[-1])
    tab.press("Undo")
    assert np.array_equal(tab.head(), heads[-1])
    tab.press("Redo")
    tab.press("Undo")
    tab.mode("Face")
    tab.press("More")
    slider = tab.page.get_by_role("slider", name="Big nose")
    slider.focus()
    for _ in range(3):
        tab.changed(lambda: slider.press("ArrowRight"))
    tab.page.get_by_label("Front %").fill("4")
    tab.press("Pull")
    tab.save("session", tmp_path / "session.json")
    tab.save("face", tmp_path / "face.zip")
    names = [operation.name for operation in read_session(tmp_path / "session.json").operations]
    assert names[:5] == ["draw", "draw", "draw", "draw", "caricaturize"] and names[-1] == "handle"
    assert "semantic" in names
    saved = faces(tmp_path / "face.zip")
    assert replayed(tmp_path / "session.json", tmp_path) == saved["face.obj"]
    assert (tmp_path / "replayed.npz").read_bytes() == saved["face.npz"]
    assert saved["session.json"] == (tmp_path / "session.json").read_bytes()
    assert not tab.faults


def test_a_line_of_the_face_is_erased_and_drawn_anew(tab, tmp_path):
    tab.mode("Redraw")
    tab.lines(20)
    before = tab.head()
    tab.changed(lambda: tab.move([[150, 240 + 8 * k] for k in range(11)]))
    tab.page.get_by_role("button", name="Pen", pressed=True).wait_for()
    assert np.array_equal(tab.head(), before)
    tab.draw([[150, 240], [130, 260], [124, 280], [132, 300], [152, 322]])
    moved = np.array(tab.head()) - before
    assert np.abs(moved).max() > 5e-3
    tab.press("Undo")
    tab.press("Undo")
    tab.becomes(before)
    tab.press("Redo")
    tab.press("Redo")
    tab.save("session", tmp_path / "session.json")
    tab.save("face", tmp_path / "face.zip")
    assert replayed(tmp_path / "session.json", tmp_path) == faces(tmp_path / "face.zip")["face.obj"]
    assert not tab.faults


def test_the_page_asks_nobody_but_its_server(tab, server):
    tab.mode("Face")
    tab.page.wait_for_timeout(500)
    own = server.url.partition("?")[0]
    others = [url for url in tab.asked if not url.startswith((own, "data:", "blob:"))]
    assert not others and len(tab.asked) > 10


def test_expressions_move_both_sides_and_the_rig_has_all_of_them(tab, tmp_path):
    tab.mode("Face")
    tab.page.get_by_text("Expressions", exact=True).click()
    before = np.array(tab.head()).reshape(-1, 3)
    slider = tab.page.get_by_role("slider", name="Mouth smile left")
    slider.scroll_into_view_if_needed()
    slider.focus()
    tab.changed(lambda: slider.press("End"))
    tab.page.wait_for_timeout(300)
    moved = np.array(tab.head()).reshape(-1, 3) - before
    left, right = (np.abs(moved[side * before[:, 0] > 0.005]).max() for side in (1, -1))
    assert min(left, right) > 2e-3
    tab.save("rig", tmp_path / "rig.glb")
    assert len(read_gltf(tmp_path / "rig.glb").names) == 52


def test_a_point_is_dragged_on_the_surface(tab):
    tab.mode("Face")
    tab.page.get_by_role("switch", name="Drag points on the head").click()
    tab.page.wait_for_function("document.querySelector('.caricli-head canvas').style.cursor == 'crosshair'")
    before = np.array(tab.head()).reshape(-1, 3)
    canvas = tab.page.locator(".caricli-head canvas")
    box = canvas.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.57 * box["height"]
    shown = tab.shown
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    for step in range(1, 9):
        tab.page.mouse.move(x, y + 3 * step)
    pulled = "+(document.querySelector('.caricli-head canvas').dataset.pulled || 0) > 0"
    tab.page.wait_for_function(pulled, timeout=PATIENCE)
    tab.page.mouse.up()
    tab.wait(shown)
    moved = np.array(tab.head()).reshape(-1, 3) - before
    assert moved[np.abs(moved).sum(1).argmax(), 1] < -2e-3


def test_an_obj_that_came_without_its_materials_is_opened_and_said(tab, tmp_path, head_template):
    write_mesh(tmp_path / "painted.obj", head_template)
    own = (tmp_path / "painted.obj").read_text()
    (tmp_path / "painted.obj").write_text("mtllib painted.mtl\n" + own)
    tab.open(tmp_path / "painted.obj")
    tab.told("Opened without its materials: caricli studio painted.obj opens it in them.")


def test_what_is_no_file_of_ours_is_refused_in_words(tab, tmp_path):
    bad = tmp_path / "notes.npz"
    bad.write_bytes(b"PK\x03\x04 and nothing else")
    before = tab.shown
    tab.open(bad)
    tab.told("notes.npz: expected")
    assert tab.shown == before and str(tmp_path) not in tab.page.locator(".caricli-told").inner_text()
    far = tmp_path / "far.json"
    far.write_text(json.dumps({"schema": "caricli.session/1", "start": None, "operations": [{"name": "rm"}]}))
    tab.open(far)
    tab.told("operation 0: expected one of draw")


def test_what_cannot_be_saved_is_refused_in_words(tab):
    tab.page.get_by_role("button", name="Save").click()
    tab.page.locator("[data-kind=landmarks]").click()
    tab.told("expected landmarks")


def test_a_session_and_a_sketch_open_in_the_page(tab, tmp_path):
    tab.draw(OUTLINE)
    tab.draw(EYES[0])
    drawn = tab.head()
    tab.save("session", tmp_path / "session.json")
    tab.save("sketch", tmp_path / "lines.json")
    tab.press("New")
    assert not np.array_equal(tab.head(), drawn)
    tab.changed(lambda: tab.open(tmp_path / "session.json"))
    tab.lines(2)
    assert np.array_equal(tab.head(), drawn)
    tab.press("New")
    tab.changed(lambda: tab.open(tmp_path / "lines.json"))
    tab.lines(2)


@pytest.mark.parametrize("size", [(900, 300), (300, 900)])
def test_a_picture_keeps_its_shape_on_the_canvas(tab, tmp_path, size):
    Image.new("RGB", size, (200, 190, 180)).save(tmp_path / "wall.png")
    tab.page.get_by_role("button", name="Eraser").click()
    tab.changed(lambda: tab.open(tmp_path / "wall.png"))
    tab.page.wait_for_function(f"document.querySelector('.caricli-canvas canvas').width == {size[0]}")
    box = tab.page.locator(".caricli-canvas canvas").first.bounding_box()
    assert box["width"] / box["height"] == pytest.approx(size[0] / size[1], rel=0.01)
    tab.draw([(250, 80), (260, 90)])
    tab.save("session", tmp_path / "session.json")
    (erased,) = read_session(tmp_path / "session.json").operations
    assert erased.name == "erase" and erased.parameters["radius"] == pytest.approx(10 * 900 / 512)


def test_a_texture_that_comes_late_is_left(tab):
    skin = "document.querySelector('.caricli-head').caricli"
    late = f"{skin}.texture('skin', document.createElement('canvas').toDataURL())"
    assert tab.page.evaluate(f"{late}.then(() => Boolean({skin}.materials.skin.map))")
    worn = f"Promise.all([{late}, {skin}.texture('skin', null)]).then(() => Boolean({skin}.materials.skin.map))"
    assert not tab.page.evaluate(worn)


def test_a_layout_that_comes_late_gets_its_positions(tab):
    head = "document.querySelector('.caricli-head').caricli"
    late = f"{head}.layout({tab.shown - 1}).then(() => {head}.show({tab.shown - 1}))"
    assert tab.page.evaluate(f"{late}.then(() => Math.max(...{head}.geometry.attributes.position.array))") > 0.05
    assert not tab.faults


def test_a_tab_that_the_server_has_ended_says_so(tab):
    tab.page.route("**/studio/*/*/*", lambda route: route.fulfill(status=404))
    tab.page.get_by_role("button", name="New").click()
    tab.page.get_by_role("alert").get_by_text("this one has ended").wait_for()
    assert not tab.faults


def test_the_first_click_on_light_or_dark_is_seen_on_a_dark_system(browser, server):
    context = browser.new_context(color_scheme="dark")
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    for look in ("light", "dark", "light"):
        tab.page.get_by_role("button", name="Light or dark").click()
        tab.page.locator(f"body.body--{look}").wait_for()
    context.close()


@pytest.mark.parametrize("path", ["nope", "docs", "openapi.json", "studio/nobody/nothing"])
def test_there_is_no_page_under_other_addresses(tab, path):
    assert tab.page.request.get(urljoin(tab.page.url, path)).status == 404


def test_two_tabs_do_not_see_each_other(browser, server):
    context = browser.new_context()
    context.set_default_timeout(PATIENCE)
    one, other = (Tab(context.new_page()) for _ in range(2))
    one.go(server.url)
    other.go(server.url)
    untouched = other.head()
    one.draw(OUTLINE)
    assert np.array_equal(other.head(), untouched) and not np.array_equal(one.head(), untouched)
    other.draw(EYES[0])
    other.draw(EYES[1])
    other.lines(2)
    one.lines(1)
    one.go(server.url)
    one.lines(1)
    context.close()


def test_a_server_that_is_killed_comes_back_with_the_drawing(browser, tmp_path):
    server = Server(tmp_path)
    context = browser.new_context()
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    for line in (OUTLINE, EYES[0]):
        tab.draw(line)
    drawn = tab.head()
    server.kill()
    tab.page.get_by_text("The server does not answer").wait_for()
    tab.move(EYES[1])
    again = Server(tmp_path, port=server.port)
    try:
        tab.told("Your drawing is back")
        tab.lines(3)
        tab.press("Undo")
        tab.lines(2)
        tab.becomes(drawn)
    finally:
        context.close()
        assert again.stop() == 130


def test_the_first_line_without_a_server_comes_back_on_its_picture(browser, tmp_path):
    Image.new("RGB", (600, 500), (200, 190, 180)).save(tmp_path / "wall.png")
    server = Server(tmp_path, "wall.png")
    context = browser.new_context()
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    server.kill()
    tab.page.get_by_text("The server does not answer").wait_for()
    tab.move(MOUTH)
    again = Server(tmp_path, "wall.png", port=server.port)
    try:
        tab.told("Your drawing is back")
        tab.lines(1)
        assert tab.page.evaluate("document.querySelector('.caricli-canvas canvas').width") == 600
        assert tab.page.locator(".caricli-canvas img").count() == 1
    finally:
        context.close()
        again.kill()


@pytest.mark.parametrize("long", [False, True])
def test_what_was_drawn_on_an_opened_picture_comes_back_when_it_is_opened_again(tab, tmp_path, long):
    Image.new("RGB", (600, 500), (200, 190, 180)).save(tmp_path / "wall.png")
    tab.changed(lambda: tab.open(tmp_path / "wall.png"))
    tab.draw(OUTLINE)
    tab.draw(EYES[0])
    if long:
        tab.page.evaluate(MANY)  # more than a message of the page may hold
    tab.page.reload()
    tab.wait(0)
    tab.told("Open wall.png again")
    tab.changed(lambda: tab.open(tmp_path / "wall.png"))
    tab.lines(4 if long else 2)
    assert not tab.faults


def test_a_damaged_drawing_that_the_browser_kept_is_told_and_the_page_goes_on(tab):
    tab.page.evaluate("localStorage.setItem(caricliKeep.name, '{damaged')")
    tab.page.reload()
    tab.wait(0)
    tab.told("drawing.json: ")
    tab.draw(OUTLINE)
    tab.lines(1)
    assert not tab.faults


def test_the_browser_keeps_the_tabs_that_were_worked_on_last(tab):
    for name, at in ((f"tab{number:02}", 100 - number) for number in range(40)):
        text = "x" * 4_000_000 if name == "tab00" else "{}"
        tab.page.evaluate("([name, text]) => localStorage.setItem(name, text)", [f"caricli-studio-{name}", text])
        tab.page.evaluate("([name, at]) => localStorage.setItem(name, at)", [f"caricli-at-caricli-studio-{name}", at])
    kept = "Object.keys(localStorage).filter(name => name.startsWith('caricli-studio-')).sort()"
    assert tab.page.evaluate(f"caricliKeep.write() || {kept}")[1:] == [f"caricli-studio-tab{k:02}" for k in range(31)]
    tab.page.evaluate("caricliKeep.operations.push('x'.repeat(2000000)) && caricliKeep.write()")
    assert tab.page.evaluate(f"{kept} == caricliKeep.name && caricliKeep.lost == ''")


def test_a_host_that_is_no_name_is_none_of_ours():
    result = CliRunner().invoke(cli, ["studio", "--no-browser", "--host", "x" * 64])
    assert result.exit_code == 2 and "cannot be served from: no such address" in result.stderr


def test_a_port_that_another_studio_is_about_to_serve_is_taken(tmp_path):
    server = Server(tmp_path)
    try:
        result = CliRunner().invoke(cli, ["studio", "--no-browser", "--port", str(server.port)])
        assert result.exit_code == 2 and result.stderr.endswith("cannot be served from: Address already in use\n")
    finally:
        server.kill()


@pytest.mark.parametrize("words", [[], ["--host", "0.0.0.0"]])
def test_others_need_the_token(tmp_path, words, browser):
    server = Server(tmp_path, *words)
    try:
        context = browser.new_context()
        context.set_default_timeout(PATIENCE)
        page = context.new_page()
        bare = server.url.partition("?")[0].replace("0.0.0.0", "127.0.0.1")
        assert page.goto(bare).status == 403
        tab = Tab(page)
        tab.go(bare + "?" + server.url.partition("?")[2])
        assert "token" not in page.url
        context.close()
    finally:
        server.kill()


def test_what_a_hand_does_while_something_is_refused_is_shown(monkeypatch):
    tried = []

    async def run(function, operation):
        tried.append(operation.name)
        if operation.name == "first":
            page.attempt(Operation("second"))
            raise InputError("no")

    studio: Any = SimpleNamespace(run=run)
    desk: Any = SimpleNamespace(key="", attempt=None)
    page = Page(studio, desk)
    said = []
    monkeypatch.setattr(page, "say", said.append)
    monkeypatch.setattr(page, "_frame", lambda: said.append("shown"))
    page._wanted = Operation("first")
    page._bare = "face.obj"
    run_apart(page._attempts())
    assert tried == ["first", "second"] and said == ["no", "shown"] and page._bare == "face.obj"


def test_a_face_that_is_drawn_takes_off_what_a_painted_one_wore(monkeypatch):
    mesh = SimpleNamespace(topology_id="", uvs=np.zeros((1, 2)))
    bare, dyed, hairy = (
        SimpleNamespace(mesh=mesh, pictures=pictures, hair=hair)
        for pictures, hair in ((Pictures(), None), (Pictures(np.zeros((4, 4, 3), np.uint8)), None), (Pictures(), "wig"))
    )
    desk: Any = SimpleNamespace(key="", work=SimpleNamespace(face=bare))
    studio: Any = None
    page = Page(studio, desk)
    laid: list[str] = []
    monkeypatch.setattr("caricli.studio.page.ui.run_javascript", laid.append)
    monkeypatch.setattr(page, "head", SimpleNamespace(id=1, run_method=lambda *words: None), raising=False)
    monkeypatch.setattr(page, "_textured", lambda: None)
    for count, face in enumerate((bare, dyed, bare, hairy, bare), 1):
        desk.work.face = face
        page._frame()
        page._frame()
        assert len(laid) == count
