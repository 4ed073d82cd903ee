import numpy as np
import pytest

from caricli.render.backdrop import PAPER
from caricli.render.sheets import sketch_sheet as sheet
from caricli.structures import Camera, Face
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

CANVAS = (256, 128)
CAMERA = Camera(60.0, np.diag([1.0, -1, -1]), np.array([128.0, 64.0]))


def line(y, kind):
    return Stroke(np.array([[20.0, y], [230.0, y]]), kind)


@pytest.fixture
def panels(lopsided_head, monkeypatch):
    """Pictures of a sheet of a silhouette above and a feature below, with a curve between them."""
    told = []
    monkeypatch.setattr(sheet, "contact_sheet", lambda pictures, columns: told.extend(pictures))
    monkeypatch.setattr(sheet, "head_views", lambda head, views, size, fine, look: [np.zeros((size, size, 3))] * 3)
    sketch = Sketch((line(10.25, StrokeKind.SILHOUETTE), line(117.75, StrokeKind.FEATURE)), CANVAS)
    curves = {"lip": np.array([[20.0, 40.25], [230.0, 40.25]])}

    def drawn(image=None):
        told.clear()
        sheet.sketch_sheet(Face(lopsided_head, CAMERA), lopsided_head, sketch, curves, image)
        return [picture.astype(int) for picture in told]

    return drawn


def rows_of(picture, colour):
    return np.unique(np.nonzero((np.abs(picture - colour).max(2) < 40).sum(1) > 300)[0])


def test_lines_have_the_colours_of_their_kinds_and_places_in_a_larger_canvas(panels):
    """Twice as large, from the middle of a pixel to that of another."""
    pictures = panels()
    assert len(pictures) == 5 and pictures[0].shape == (512, 512, 3)
    for picture in pictures[:2]:
        assert rows_of(picture, sheet._INK[StrokeKind.SILHOUETTE]).mean() == pytest.approx(21, abs=0.6)
        assert rows_of(picture, sheet._INK[StrokeKind.FEATURE]).mean() == pytest.approx(236, abs=0.6)
    assert not len(rows_of(pictures[0], sheet._CURVE))
    assert rows_of(pictures[1], sheet._CURVE).mean() == pytest.approx(81, abs=0.6)


def test_the_face_is_drawn_where_its_camera_has_it(panels):
    lines, over = panels()[:2]
    face = (np.abs(over - lines).max(2) > 25)[100:230]
    rows, columns = np.nonzero(face)
    assert face.mean() > 0.05 and abs(np.median(columns) - 256) < 40
    assert (lines[300:] == PAPER).all()


def test_what_a_sketch_was_drawn_over_fills_its_canvas_and_the_rest_is_paper(panels):
    image = np.zeros((128, 256, 3), np.uint8)
    image[:, :128] = 10, 60, 250
    image[:, 128:] = 250, 240, 10
    picture = panels(image)[0]
    assert (picture[150, 100] == (10, 60, 250)).all() and (picture[150, 400] == (250, 240, 10)).all()
    assert (picture[260:] == PAPER).all() and (picture[250, 100] != PAPER).any()


def test_a_small_drawing_is_come_near_to(lopsided_head, monkeypatch):
    told = []
    monkeypatch.setattr(sheet, "contact_sheet", lambda pictures, columns: told.extend(pictures))
    monkeypatch.setattr(sheet, "head_views", lambda head, views, size, fine, look: [np.zeros((size, size, 3))] * 3)
    small = Camera(3.0, CAMERA.rotation, np.array([200.0, 30.0]))
    outline = Stroke(np.array([[195.0, 25], [205, 25], [205, 35], [195, 35], [195, 25]]), StrokeKind.SILHOUETTE)
    curves = {"lip": np.array([[196.0, 30], [204, 30]])}
    for image in (None, np.full((128, 256, 3), 250, np.uint8)):
        sheet.sketch_sheet(Face(lopsided_head, small), lopsided_head, Sketch((outline,), CANVAS), curves, image)
    near, over, whole = told[0], told[1], told[5]
    red = [
        np.argwhere(np.abs(each.astype(int) - sheet._INK[StrokeKind.SILHOUETTE]).max(2) < 40) for each in (near, whole)
    ]
    # 1.15 times the drawing are as wide as the picture; over a picture its canvas is.
    assert np.ptp(red[0], axis=0) == pytest.approx([512 / 1.15] * 2, abs=3)
    assert red[0].mean(0) == pytest.approx([255.5, 255.5], abs=12)
    assert np.ptp(red[1], axis=0) == pytest.approx([21, 21], abs=3)
    rows = np.nonzero((np.abs(over.astype(int) - sheet._CURVE).max(2) < 120).sum(1) > 300)[0]
    assert rows.mean() == pytest.approx(255.5, abs=1)
