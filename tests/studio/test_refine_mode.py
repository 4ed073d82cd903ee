"""Gestures on the head in Chromium, drawn with a pointer as a person would."""

import asyncio
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.io.session import read_session
from caricli.methods.session.work import Work
from caricli.structures import Operation
from caricli.studio.desk import Desk
from caricli.studio.modes.refine_mode import RefineMode
from caricli.studio.page import Page
from tests.studio.conftest import run_apart
from tests.studio.strokes import place, roll, stroke, use

TURN = np.linspace(0, 2 * np.pi, 40)


@pytest.fixture
def refining(tab):
    tab.mode("Refine")
    return tab


def test_gestures_change_the_face_and_arrows_undo_them(refining, head_template, tmp_path):
    tab = refining
    nose = int(head_template.annotation.landmarks[30])
    start = tab.head()
    use(tab, "Gesture")
    tip = place(tab, nose)
    tab.page.keyboard.press("Control+z")
    tab.told("There is nothing to undo.")
    tab.changed(lambda: stroke(tab, tip + 40 * np.stack([np.cos(TURN), np.sin(TURN)], 1)))
    tab.told("Region.")
    tab.page.get_by_text("a region", exact=True).wait_for()
    tab.page.screenshot(path=tmp_path / "region.png")
    tab.changed(lambda: stroke(tab, roll(tip + [-60, 60], 2, -1)))
    tab.told("Bulge 2.")
    bulged = tab.head()
    assert bulged[3 * nose + 2] > start[3 * nose + 2] + 0.003
    tab.page.screenshot(path=tmp_path / "bulge.png")
    tab.changed(lambda: stroke(tab, tip + np.array([[40, -40], [20, -20], [0, 0], [20, 20], [40, 40]])))
    tab.told("Undone: bulge.")
    tab.becomes(start)
    tab.changed(lambda: stroke(tab, tip + np.array([[-40, -40], [-20, -20], [0, 0], [-20, 20], [-40, 40]])))
    tab.told("Redone: bulge.")
    tab.becomes(bulged)
    tab.save("session", tmp_path / "session.json")
    assert [each.name for each in read_session(tmp_path / "session.json").operations] == ["region", "bulge"]
    assert not tab.faults


def test_a_button_and_a_key_for_each_from_any_side(refining, head_template, tmp_path):
    tab = refining
    marks = head_template.annotation.landmarks
    tab.page.get_by_role("button", name="Left", exact=True).click()
    use(tab, "Brush")
    tip = place(tab, marks[30])
    tab.changed(lambda: stroke(tab, [tip, tip + [2, 1]]))
    tab.page.get_by_text("handles").wait_for()
    tab.page.screenshot(path=tmp_path / "handles.png")
    start = tab.head()
    use(tab, "Line")
    tab.changed(lambda: stroke(tab, [tip, tip + [-10, 4], tip + [-20, 8]]))
    tab.told("Line.")
    assert tab.head()[3 * int(marks[30]) + 2] > start[3 * int(marks[30]) + 2] + 0.002
    tab.page.screenshot(path=tmp_path / "line.png")
    tab.changed(lambda: tab.page.get_by_role("button", name="Press in 1").click())
    tab.told("Press in 1.")
    tab.changed(lambda: tab.page.keyboard.press("d"))
    tab.told("Deselect.")
    tab.page.keyboard.press("2")
    tab.told("expected a region or handles to bulge, found neither")
    assert not tab.faults


def test_a_scribble_does_nothing(refining, head_template):
    tab = refining
    use(tab, "Gesture")
    tip = place(tab, head_template.annotation.landmarks[30])
    before = tab.head()
    stroke(tab, tip + 60 * np.random.default_rng(3).uniform(-1, 1, (24, 2)))
    tab.told("Nothing was done")
    assert tab.head() == before


def test_what_comes_after_a_stroke_is_done_after_it(monkeypatch):
    anything: Any = None
    monkeypatch.setattr("caricli.methods.session.history.operate", lambda work, *_: work)
    monkeypatch.setattr("caricli.studio.modes.refine_mode.meaning_of", lambda stroke, tools: Operation("region"))

    async def run(function, *values):
        await asyncio.sleep(0)
        return function(*values)

    async def play():
        await asyncio.gather(mode._gesture(Operation("gesture")), mode._deselect(), page.undo())

    studio: Any = SimpleNamespace(run=run, tools=None)
    desk = Desk(anything, Work(anything))
    page = Page(studio, desk)
    monkeypatch.setattr(page, "say", lambda *words: None)
    monkeypatch.setattr(page, "_after", lambda *values: None)
    mode = RefineMode(page)
    run_apart(play())
    assert [each.name for each in desk.history.done] == ["region"]
    assert [each.name for each in desk.history.undone] == ["deselect"]
