"""Drawing with a pen that feels pressure, and with a finger on a tablet that is held upright."""

import pytest

from caricli.io.sketches.sketch import read_sketch
from tests.studio.conftest import PATIENCE, Tab

LINE = [(160 + 8 * k, 140 + 10 * k) for k in range(20)]


@pytest.fixture
def tablet(browser, server):
    context = browser.new_context(viewport={"width": 820, "height": 1180}, has_touch=True, accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    yield tab
    context.close()


def on_screen(tab):
    """The line where the canvas is."""
    box = tab.page.locator(".caricli-canvas canvas:visible").bounding_box()
    return [(box["x"] + x * box["width"] / 512, box["y"] + y * box["height"] / 512) for x, y in LINE]


def drawn(tab, path):
    """The strokes that the server has."""
    tab.save("sketch", path)
    return read_sketch(path).strokes


def test_the_pressure_of_a_pen_is_kept(tab, tmp_path):
    pen = tab.page.context.new_cdp_session(tab.page)

    def touch(kind, place, force):
        given = {"x": place[0], "y": place[1], "force": force, "pointerType": "pen", "button": "left", "buttons": 1}
        pen.send("Input.dispatchMouseEvent", {"type": kind, "clickCount": 1, **given})

    def line():
        places = on_screen(tab)
        touch("mousePressed", places[0], 0.1)
        for number, place in enumerate(places):
            touch("mouseMoved", place, 0.1 + 0.8 * number / len(places))
        touch("mouseReleased", places[-1], 0)

    tab.changed(line)
    (stroke,) = drawn(tab, tmp_path / "pen.json")
    assert stroke.pressure[-1] > 0.7 > 0.3 > stroke.pressure[1] and len(stroke.points) > 15


def test_a_finger_draws_on_a_tablet(tablet, tmp_path):
    hand = tablet.page.context.new_cdp_session(tablet.page)

    def line():
        places = [[{"x": x, "y": y}] for x, y in on_screen(tablet)]
        hand.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": places[0]})
        for place in places[1:]:
            hand.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": place})
        hand.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    before = tablet.page.evaluate("window.scrollY")
    tablet.changed(line)
    (stroke,) = drawn(tablet, tmp_path / "finger.json")
    assert stroke.pressure is None and len(stroke.points) > 15
    assert tablet.page.evaluate("window.scrollY") == before
    tablet.page.screenshot(path=tmp_path / "tablet.png", full_page=True)
    root = "document.documentElement"
    assert tablet.page.evaluate(f"[{root}.scrollWidth, {root}.scrollHeight]") == [820, 1180]


def test_all_modes_are_in_sight_on_a_phone(browser, server):
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    context.set_default_timeout(PATIENCE)
    tab = Tab(context.new_page())
    tab.go(server.url)
    for name in ("Draw", "Redraw", "Landmarks", "Refine", "Face"):
        box = tab.page.get_by_role("tab", name=name, exact=True).bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 390
    assert tab.page.evaluate("document.documentElement.scrollWidth") == 390
    context.close()
