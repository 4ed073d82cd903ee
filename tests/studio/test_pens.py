"""Drawing with a pen that feels pressure, and with a finger on a tablet that is held upright."""

import numpy as np
import pytest
from PIL import Image

from caricli.io.sketches.sketch import read_sketch
from tests.studio.conftest import PATIENCE, Tab
from tests.studio.marks import Marks

LINE = [(160 + 8 * k, 140 + 10 * k) for k in range(20)]
HELD = """() => {
  const { stroke, pulled } = document.querySelector('.caricli-head').caricli;
  return { points: stroke ? stroke.slice() : pulled ? pulled.by.toArray() : null };
}"""
"""What a hand does on the head."""

TURNS = "document.querySelector('.caricli-head').caricli.controls.enabled"


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


def written(tab, hand):
    """A line by a pen that is pressed harder and harder. hand: session of the browser's own protocol."""

    def touch(kind, place, force):
        given = {"x": place[0], "y": place[1], "force": force, "pointerType": "pen", "button": "left", "buttons": 1}
        hand.send("Input.dispatchMouseEvent", {"type": kind, "clickCount": 1, **given})

    places = on_screen(tab)
    touch("mousePressed", places[0], 0.1)
    for number, place in enumerate(places):
        touch("mouseMoved", place, 0.1 + 0.8 * number / len(places))
    touch("mouseReleased", places[-1], 0)


def touched(hand, kind, *places):
    """Fingers that come, move, or go. places: of all that are down."""
    points = [{"x": float(x), "y": float(y), "id": number} for number, (x, y) in enumerate(places)]
    hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_the_pressure_of_a_pen_is_kept(tab, tmp_path):
    pen = tab.page.context.new_cdp_session(tab.page)
    tab.changed(lambda: written(tab, pen))
    (stroke,) = drawn(tab, tmp_path / "pen.json")
    assert stroke.pressure[-1] > 0.7 > 0.3 > stroke.pressure[1] and len(stroke.points) > 15


def test_a_finger_draws_on_a_tablet(tablet, tmp_path):
    hand = tablet.page.context.new_cdp_session(tablet.page)

    def line():
        places = on_screen(tablet)
        touched(hand, "touchStart", places[0])
        for place in places[1:]:
            touched(hand, "touchMove", place)
        touched(hand, "touchEnd")

    before = tablet.page.evaluate("window.scrollY")
    tablet.changed(line)
    (stroke,) = drawn(tablet, tmp_path / "finger.json")
    assert stroke.pressure is None and len(stroke.points) > 15
    assert tablet.page.evaluate("window.scrollY") == before
    tablet.page.screenshot(path=tmp_path / "tablet.png", full_page=True)
    root = "document.documentElement"
    assert tablet.page.evaluate(f"[{root}.scrollWidth, {root}.scrollHeight]") == [820, 1180]


def test_a_palm_beside_a_pen_draws_nothing(tablet, tmp_path):
    hand = tablet.page.context.new_cdp_session(tablet.page)
    start, *_, end = on_screen(tablet)

    def line():
        touched(hand, "touchStart", end)
        written(tablet, hand)
        touched(hand, "touchEnd")

    tablet.changed(line)
    touched(hand, "touchStart", start)
    touched(hand, "touchMove", end)
    touched(hand, "touchEnd")
    tablet.page.wait_for_timeout(500)
    (stroke,) = drawn(tablet, tmp_path / "pen.json")
    assert stroke.pressure is not None and len(stroke.points) > 15


def test_a_touch_that_the_browser_takes_back_draws_nothing(tablet, tmp_path):
    hand = tablet.page.context.new_cdp_session(tablet.page)
    start, *_, end = on_screen(tablet)
    for kind in ("touchCancel", "touchEnd"):
        touched(hand, "touchStart", start)
        touched(hand, "touchMove", end)
        touched(hand, kind)
    tablet.lines(1)
    tablet.page.wait_for_timeout(500)
    assert len(drawn(tablet, tmp_path / "finger.json")) == 1


@pytest.mark.parametrize("mode", ["Refine", "Face"])
def test_a_second_finger_on_the_head_moves_nothing(tablet, mode):
    hand = tablet.page.context.new_cdp_session(tablet.page)
    tablet.mode(mode)
    if mode == "Face":
        tablet.page.get_by_role("switch", name="Drag points on the head").click()
    tablet.page.wait_for_function("document.querySelector('.caricli-head canvas').style.cursor == 'crosshair'")
    box = tablet.page.locator(".caricli-head canvas").bounding_box()
    one = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
    other = one + [60, 40]
    before = tablet.shown
    touched(hand, "touchStart", one)
    touched(hand, "touchMove", one + [0, 6])
    held = tablet.page.evaluate(HELD)
    touched(hand, "touchStart", one + [0, 6], other)
    touched(hand, "touchMove", one + [0, 6], other + [0, 20])
    assert tablet.page.evaluate(HELD) == held and held["points"]
    touched(hand, "touchCancel")
    # Nothing can forbid a cancel, so that the browser does not wait until the page has heard of it.
    tablet.page.wait_for_function(f"({HELD})().points === null && {TURNS}")
    tablet.page.wait_for_timeout(500)
    assert tablet.shown == before


def test_a_second_finger_moves_no_landmark(tablet, tmp_path):
    Image.new("RGB", (512, 512), (190, 170, 150)).save(tmp_path / "wall.png")
    tablet.changed(lambda: tablet.open(tmp_path / "wall.png"))
    marks = Marks(tablet)
    marks.begin()
    hand = tablet.page.context.new_cdp_session(tablet.page)
    one = marks.where(30)
    touched(hand, "touchStart", one)
    touched(hand, "touchMove", one + [0, 10])
    held = marks.points()
    touched(hand, "touchStart", one + [0, 10], one + [60, 40])
    touched(hand, "touchMove", one + [0, 10], one + [60, 70])
    assert np.array_equal(marks.points(), held)
    touched(hand, "touchEnd")


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
