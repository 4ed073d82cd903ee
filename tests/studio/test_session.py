"""A session of all modes in Chromium, done again on the command line."""

import numpy as np
import pytest
from PIL import Image

from caricli.io.landmarks import write_landmarks
from caricli.io.session import read_session
from caricli.methods.marks.lay_mean_shape import lay_mean_shape
from caricli.structures.detection import FaceFrame
from tests.studio.conftest import PATIENCE, Server, Tab
from tests.studio.marks import Marks
from tests.studio.strokes import place, roll, stroke, use
from tests.studio.test_page import EYES, MOUTH, OUTLINE, faces, replayed

SIDE = 512
PLAYED = [
    *["draw"] * 5,
    "erase",
    *["marks", "mark", "mark_off", "mark_face"],
    *["cut", "mend"],
    *["region", "bulge", "deselect", "brush", "line"],
    *["caricaturize", "semantic", "handle", "expression"],
]
"""Names of the operations, as they stand in the file."""


@pytest.fixture
def folder(tmp_path, head_template):
    """A picture and its landmarks."""
    Image.new("RGB", (SIDE, SIDE), (190, 170, 150)).save(tmp_path / "wall.png")
    frame = FaceFrame(np.array([256.0, 270.0]), 300.0, 0.0)
    write_landmarks(tmp_path / "wall.pts", lay_mean_shape(head_template, frame, (SIDE, SIDE)))
    return tmp_path


@pytest.fixture
def tab(browser, folder):
    server = Server(folder, str(folder / "wall.png"))
    context = browser.new_context(viewport={"width": 1280, "height": 720}, accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    own = Tab(context.new_page())
    own.go(server.url)
    yield own
    context.close()
    server.kill()


def draw(tab):
    """Five lines, one of them rubbed out."""
    for line in (OUTLINE, *EYES, MOUTH, [[256, 250], [250, 300], [262, 310]]):
        tab.draw(line)
    tab.page.get_by_role("button", name="Eraser").click()
    tab.draw([[256, 250], [250, 300], [262, 310]])


def place_landmarks(tab):
    """Those beside the picture, a corner of the mouth moved, a point switched off, and the face of that."""
    marks = Marks(tab)
    marks.begin()
    marks.drag(48, (-14, 9))
    marks.press("Delete")
    tab.press("Make the face")


def redraw(tab):
    """The outline of a cheek erased and drawn anew, farther out."""
    tab.mode("Redraw")
    tab.page.locator(".caricli-canvas canvas:visible").wait_for()
    tab.lines(20)
    tab.changed(lambda: tab.move([[150, 240 + 8 * k] for k in range(11)]))
    tab.page.get_by_role("button", name="Pen", pressed=True).and_(tab.page.locator(":visible")).wait_for()
    tab.draw([[150, 240], [130, 260], [124, 280], [132, 300], [152, 322]])


def refine(tab, tip_id, chin_id):
    """The nose bulged by a gesture, the chin pulled by a line."""
    tab.mode("Refine")
    use(tab, "Gesture")
    tip = place(tab, tip_id)
    turn = np.linspace(0, 2 * np.pi, 40)
    tab.changed(lambda: stroke(tab, tip + 40 * np.stack([np.cos(turn), np.sin(turn)], 1)))
    tab.told("Region.")
    tab.changed(lambda: stroke(tab, roll(tip + [-60, 60], 1, -1)))
    tab.told("Bulge 1.")
    tab.changed(lambda: tab.page.keyboard.press("d"))
    use(tab, "Brush")
    chin = place(tab, chin_id)
    tab.changed(lambda: stroke(tab, [chin, chin + [2, 0]]))
    use(tab, "Line")
    tab.changed(lambda: stroke(tab, [chin, chin + [0, 8], chin + [0, 16]]))


def change(tab):
    """A label, a point and an expression."""
    tab.mode("Face")
    tab.press("A little")
    slider = tab.page.get_by_role("slider", name="Big nose")
    slider.focus()
    tab.changed(lambda: slider.press("PageUp"))
    tab.page.get_by_label("Front %").fill("3")
    tab.press("Pull")
    tab.page.get_by_text("Expressions", exact=True).click()
    smile = tab.page.get_by_role("slider", name="Mouth smile left")
    smile.scroll_into_view_if_needed()
    smile.focus()
    tab.changed(lambda: smile.press("PageUp"))


def test_operations_of_all_modes_are_done_again_to_the_same_bytes(tab, folder, head_template):
    marks = head_template.annotation.landmarks
    draw(tab)
    place_landmarks(tab)
    redraw(tab)
    refine(tab, marks[30], marks[8])
    change(tab)
    tab.press("Undo")
    tab.press("Redo")
    tab.page.screenshot(path=folder / "session.png")
    tab.save("session", folder / "session.json")
    tab.save("face", folder / "face.zip")
    names = [operation.name for operation in read_session(folder / "session.json").operations]
    assert names == PLAYED and len(names) >= 20
    assert replayed(folder / "session.json", folder) == faces(folder / "face.zip")["face.obj"]
    assert (folder / "replayed.npz").read_bytes() == faces(folder / "face.zip")["face.npz"]
    assert not tab.faults
