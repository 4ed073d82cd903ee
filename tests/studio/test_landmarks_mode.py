"""Landmarks in Chromium, placed as a person would."""

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image

from caricli.errors import InputError
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.methods.marks.lay_mean_shape import lay_mean_shape
from caricli.methods.session.history import History
from caricli.methods.session.work import Work
from caricli.store.marked_folder import MarkedFolder, seen_marks
from caricli.structures import Landmarks
from caricli.structures.detection import FaceFrame
from caricli.studio.desk import Desk
from caricli.studio.modes.landmarks_mode import LandmarksMode
from caricli.studio.page import Page
from tests.studio.conftest import PATIENCE, Server, Tab, run_apart
from tests.studio.marks import CANVAS, Marks

SIZE = (300, 360)


@pytest.fixture(scope="module")
def laid(head_template):
    return lay_mean_shape(head_template, FaceFrame(np.array([150.0, 190.0]), 210.0, 0.0), SIZE)


@pytest.fixture
def folder(tmp_path, laid):
    """Three pictures, two of them without landmarks."""
    for name in ("a", "b", "c"):
        Image.new("RGB", SIZE, (190, 170, 150)).save(tmp_path / f"{name}.png")
    write_landmarks(tmp_path / "a.pts", laid)
    return tmp_path


@pytest.fixture
def marks(browser, folder):
    server = Server(folder, str(folder / "a.png"))
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    own = Marks(tab)
    own.begin()
    yield own
    assert not [fault for fault in tab.faults if "value" not in fault]
    context.close()
    server.kill()


def test_points_are_dragged_with_their_partners_undone_switched_off_and_saved(marks, folder, laid):
    assert np.allclose(marks.points(), laid.points, atol=1e-3)
    updates = marks.page.evaluate(f"{CANVAS}.updates")
    marks.drag(48, (-20, 12))
    assert marks.page.evaluate(f"{CANVAS}.updates") > updates
    zoom = marks.page.evaluate(f"{CANVAS}.zoom")
    moved = marks.points() - laid.points
    assert np.allclose(moved[48], np.array([-20, 12]) / zoom, atol=0.5)
    assert np.allclose(moved[54], np.array([20, 12]) / zoom, atol=0.7)
    assert np.abs(np.delete(moved, [48, 54], 0)).max() < 1e-5
    guess = np.array(marks.page.evaluate(f"{CANVAS}.guess"))
    assert np.linalg.norm(guess - marks.points(), axis=1)[48] < 0.03 * laid.diagonal  # the face went along
    marks.press("Control+z")
    assert np.allclose(marks.points(), laid.points, atol=1e-3)
    marks.press("Control+y")
    marks.press("Delete")
    assert np.isnan(marks.points()[48]).all() and np.isfinite(marks.points()[54]).all()
    assert marks.page.evaluate("document.activeElement.getAttribute('aria-label')") == "mouth corner right, off"
    marks.click("Done")
    marks.tab.told("Written to a.pts")
    assert np.allclose(read_landmarks(folder / "a.pts").points, marks.points(), atol=1e-6, equal_nan=True)
    marks.tab.save("pts", folder / "home.pts")
    assert (folder / "home.pts").read_bytes() == (folder / "a.pts").read_bytes()
    marks.page.locator(".marks-dot").nth(48).focus()
    marks.press("Enter")
    assert np.isfinite(marks.points()).all()
    answers = marks.done()
    marks.tab.open(folder / "home.pts")
    marks.answered(answers)
    assert np.isnan(marks.points()[48]).all()


def test_keys_and_groups(marks, folder, laid):
    marks.page.locator(".marks-dot").nth(30).focus()
    marks.page.keyboard.press("ArrowRight")
    marks.press("Shift+ArrowDown")
    assert np.allclose((marks.points() - laid.points)[30], [1, 10], atol=1e-3)
    assert marks.page.evaluate(f"{CANVAS}.scenes") == 1  # a second one takes back what keys did
    # What keys did just now comes before what a button does.
    marks.page.keyboard.press("Shift+ArrowDown")
    marks.click("Done")
    marks.tab.told("Written to a.pts")
    assert np.allclose((read_landmarks(folder / "a.pts").points - laid.points)[30], [1, 20], atol=1e-3)
    marks.page.locator(".marks-dot").nth(30).focus()
    marks.page.keyboard.press("Shift+ArrowDown")
    marks.page.get_by_role("button", name="Undo").click()
    marks.tab.told("Undone: mark.")
    marks.until(f"Math.abs({CANVAS}.points[30][1] - {laid.points[30, 1] + 20}) < 1e-3")
    marks.page.locator(".marks-dot").nth(30).focus()
    marks.page.keyboard.press("Tab")
    assert marks.page.evaluate("document.activeElement.getAttribute('aria-label')").startswith("nostril right")
    marks.click("Groups")
    marks.until(f"{CANVAS}.options.grouped")
    marks.drag(24, (6, -14))
    moved = marks.points() - laid.points
    zoom = marks.page.evaluate(f"{CANVAS}.zoom")
    assert np.allclose(moved[22:27], np.array([6, -14]) / zoom, atol=0.5)
    assert np.allclose(moved[17:22], np.array([-6, -14]) / zoom, atol=0.7)
    marks.page.get_by_role("switch", name="Both sides").click()
    answers = marks.done()
    marks.click("Larger: the group, or the whole face")
    marks.answered(answers)
    wide = marks.points()
    assert np.linalg.norm(np.ptp(wide[22:27], axis=0)) > np.linalg.norm(np.ptp(laid.points[22:27], axis=0))
    assert np.allclose(wide[17:22], (laid.points + moved)[17:22])
    answers = marks.done()
    marks.click("Make the face")
    marks.answered(answers)


def test_a_folder_goes_on_where_it_was_left(browser, folder, laid):
    server = Server(folder, str(folder))
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    marks = Marks(tab)
    try:
        marks.begin()
        tab.page.get_by_text("b.png · 1 of 3 done").wait_for()
        before = marks.done()
        marks.click("Mean shape")
        marks.answered(before)
        marks.drag(8, (0, 15))
        chin = marks.points()[8]
        tab.go(server.url)
        marks.begin()
        assert np.allclose(marks.points()[8], chin, atol=1e-3)
        marks.click("Done, next")
        tab.page.get_by_text("c.png · 2 of 3 done").wait_for()
        marks.until(f"{CANVAS}.curves.length > 10 && {CANVAS}.points[8]?.[1] != {chin[1]}")
        marks.drag(8, (0, -15))
        moved = marks.points()
        tab.go(server.url)
        marks.begin()
        tab.told("What was done with c.png is back.")
        assert np.allclose(marks.points(), moved, atol=1e-3)
        marks.click("Done, next")
        tab.told("All pictures are done")
        written = json.loads((folder / "b.json").read_text())
        assert written["image"] == {"width": 300, "height": 360}
        assert written["points"][8] == pytest.approx(chin.tolist(), abs=1e-3)
        assert (folder / "c.json").is_file()
        tab.go(server.url)
        marks.begin()
        tab.page.get_by_text("a.png · 3 of 3 done").wait_for()
        tab.page.get_by_role("button", name="The picture before").click()
        tab.page.get_by_text("c.png · 3 of 3 done").wait_for()
    finally:
        context.close()
        server.kill()


def test_a_try_that_is_taken_back_is_gone_however_late_it_is_done(monkeypatch):
    anything: Any = None
    present = Work(anything)
    late = Work(anything, landmarks=cast(Any, "tried"))
    free = Event()
    monkeypatch.setattr("caricli.studio.desk.operate", lambda *_: late if free.wait(60) else present)
    thread = ThreadPoolExecutor(1)
    studio = SimpleNamespace(run=lambda *call: asyncio.get_running_loop().run_in_executor(thread, *call))
    desk = Desk(anything, present)
    page: Any = SimpleNamespace(studio=studio, desk=desk)
    mode: Any = LandmarksMode(page)
    mode.laid = False
    mode.canvas = SimpleNamespace(run_method=lambda *_: None)
    mode._marking = lambda: SimpleNamespace(state=lambda *_: {})

    async def play():
        tried = asyncio.create_task(mode._try(SimpleNamespace(args={"name": "mark", "parameters": {}, "seq": 1})))
        back = asyncio.create_task(mode._forget())
        await asyncio.sleep(0.1)
        free.set()
        await asyncio.gather(tried, back)

    run_apart(play())
    assert desk.work is present


@pytest.mark.parametrize("seen", [True, False])
def test_landmarks_that_come_after_another_picture_was_opened_are_left(monkeypatch, laid, seen):
    anything: Any = None
    one, other = (np.zeros((4, 5, 3), np.uint8) for _ in range(2))
    desk = Desk(anything, Work(anything, picture=one))
    marked: list[Any] = []

    def operate(work, *_):
        marked.append(work)
        return work

    monkeypatch.setattr("caricli.methods.session.history.operate", operate)

    async def run(function, *values):
        if function is not seen_marks:
            return function(*values)
        if opening:
            desk._begin(History(Work(anything, picture=other), anything), None)
        return laid if seen else None

    studio: Any = SimpleNamespace(run=run)
    page = Page(studio, desk)
    monkeypatch.setattr(page, "say", lambda *words: None)
    monkeypatch.setattr(page, "_after", lambda *values: None)
    mode: Any = LandmarksMode(page)
    mode.reader = None
    mode.passed = ""
    mode._count = lambda: len(laid.points)
    mode._mean = lambda pixels: laid
    opening = False
    run_apart(mode._find())
    assert len(marked) == 1
    opening = True
    run_apart(mode._find())
    assert len(marked) == 1 and not desk.history.done


def test_a_picture_too_small_for_a_face_is_told(head_template):
    said: list[str] = []

    async def run(function, *values):
        return None if function is seen_marks else function(*values)

    desk = SimpleNamespace(work=Work(cast(Any, None), picture=np.zeros((5, 5, 3), np.uint8)))
    page: Any = SimpleNamespace(studio=SimpleNamespace(run=run), desk=desk, say=lambda *words: said.append(words[0]))
    mode: Any = LandmarksMode(page)
    mode.reader = None
    mode.passed = ""
    mode._count = lambda: 68
    mode._marking = lambda: SimpleNamespace(model=SimpleNamespace(template=head_template))
    for begin in (mode._find, mode._lay):
        run_apart(begin())
        assert said[-1].startswith("expected the landmarks of a face in the 5 x 5 image")


def test_a_picture_that_cannot_be_read_is_passed_over_and_said(folder, laid):
    folder.joinpath("c.png").write_text("no picture")

    def opened(path):
        if path.name in ("c.png", "d.png"):
            raise InputError(f"{path.name}: expected an image")

    said: list[str] = []
    shown: list[Any] = []
    Image.new("RGB", SIZE).save(folder / "e.png")

    async def run(function, *values):
        return function(*values)

    async def do(operation, words, picture):
        said.append(words)

    async def save():
        return True

    desk = SimpleNamespace(open=opened, start=None, history=SimpleNamespace(done=[]))
    marked = MarkedFolder.of(folder)
    studio = SimpleNamespace(run=run, marked=marked)
    page: Any = SimpleNamespace(
        studio=studio, desk=desk, do=do, say=said.append, begun=lambda: shown.append(mode.picture)
    )
    mode: Any = LandmarksMode(page)
    mode.picture = folder / "b.png"
    mode._save = save
    run_apart(mode._go(1))
    assert shown == [folder / "e.png"] and said == []
    for _ in range(2):
        run_apart(mode._put(None, laid, "As found."))
    assert said == ["Passed over c.png: expected an image. As found.", "As found."]
    for name in ("b", "e"):
        write_landmarks(folder / f"{name}.json", Landmarks(np.random.default_rng(0).uniform(0, 40, (68, 2))))
    run_apart(mode._next())
    assert said[2:] == ["Passed over c.png: expected an image. "] and mode.picture == folder / "e.png"
