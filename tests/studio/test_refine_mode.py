"""Gestures on the head in Chromium, drawn with a pointer as a person would."""

import numpy as np
import pytest

from caricli.io.session import read_session

TURN = np.linspace(0, 2 * np.pi, 40)


@pytest.fixture
def refining(tab):
    tab.mode("Refine")
    return tab


def place(tab, vertex):
    """Pixels of the window where a vertex is."""
    test = """vertex => {
      const head = document.querySelector('.caricli-head').caricli;
      const { scale, rotation, translation } = head.seen();
      const box = head.canvas.getBoundingClientRect();
      const at = Array.from(head.positions.slice(3 * vertex, 3 * vertex + 3));
      const along = row => scale * rotation[row].reduce((sum, each, k) => sum + each * at[k], 0) + translation[row];
      return [box.left + along(0), box.top + along(1)];
    }"""
    return np.array(tab.page.evaluate(test, int(vertex)))


def use(tab, tool):
    tab.page.get_by_role("button", name=tool, exact=True).click()
    tab.page.wait_for_function("document.querySelector('.caricli-head').caricli.tool")


def stroke(tab, points):
    tab.page.mouse.move(*points[0])
    tab.page.mouse.down()
    for point in points[1:]:
        tab.page.mouse.move(*point)
    tab.page.mouse.up()


def roll(start, loops, side):
    """A line to the right with loops above it (side -1) or below."""
    turns = np.linspace(0, 2 * np.pi * loops, 30 * loops)
    curve = np.stack([16 * np.sin(turns) + 28 * turns / (2 * np.pi), side * 20 * (1 - np.cos(turns))], 1)
    before = [[x, 0] for x in np.linspace(-50, 0, 12)]
    after = curve[-1] + [[x, 0] for x in np.linspace(0, 50, 12)]
    return start + np.concatenate([before, curve, after])


def test_gestures_change_the_face_and_arrows_undo_them(refining, head_template, tmp_path):
    tab = refining
    nose = int(head_template.annotation.landmarks[30])
    start = tab.head()
    use(tab, "Gesture")
    tip = place(tab, nose)
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
    tab.told("An arrow to the left: undone.")
    tab.becomes(start)
    tab.changed(lambda: stroke(tab, tip + np.array([[-40, -40], [-20, -20], [0, 0], [-20, 20], [-40, 40]])))
    tab.told("An arrow to the right: redone.")
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
