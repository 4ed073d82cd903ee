"""Pictures of edits: how many heads they show, and which."""

from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.edit.caricature_sheet import caricature_sheet
from caricli.methods.edit.edit_handles import edit_handles
from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic
from caricli.methods.edit.handle_points import handle_points
from caricli.methods.edit.handle_sheet import handle_sheet, handle_strip
from caricli.methods.edit.semantic_strip import semantic_strip
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.faces.encode_face import encode_face
from caricli.render.sheets.view_sheets import film_strip, view_rows
from caricli.structures import Directions, Face
from caricli.template.fine_mesh import fine_mesh


@pytest.fixture(scope="module")
def drawing(pca):
    return FaceDrawing(pca, fine_mesh(pca.template, 0), 40)


@pytest.fixture(scope="module")
def face(pca, strangers):
    return encode_face(Face(pca.template.with_vertices(strangers[0])), pca)


@pytest.fixture(scope="module")
def edit(pca, face):
    handles = handle_points([("nose_tip", [0, 0, "5%"])], [], pca.template.with_vertices(face.vertices))
    return edit_handles(face, pca, handles)


def test_handles_before_and_after_and_a_baseline(face, edit, drawing):
    views = ("front", "three-quarter", "profile")
    sheet = handle_sheet(face, edit, drawing)
    assert np.array_equal(sheet, view_rows([drawing.draw(f, views) for f in (face, edit.face)], ["before", "after"]))
    assert handle_sheet(face, edit, drawing, baseline=True).shape[0] > 1.4 * sheet.shape[0]


def test_a_baseline_shows_as_much_of_the_teeth_as_the_face(face, edit, drawing, monkeypatch):
    shown = []

    def draw(self, each, views):
        shown.append(each)
        return [np.zeros((40, 40, 4))]

    monkeypatch.setattr(FaceDrawing, "draw", draw)
    teeth = np.array([0.004, 0.001])
    handle_sheet(replace(face, teeth=teeth), edit, drawing, baseline=True)
    assert np.array_equal(shown[0].teeth, teeth) and np.array_equal(shown[2].teeth, teeth)
    assert not np.array_equal(shown[2].vertices, face.vertices)


def test_a_strip_of_handles_goes_as_far_as_was_tried(face, edit, drawing):
    strip = handle_strip(face, edit, drawing, 2)
    assert np.array_equal(strip, film_strip([drawing.draw(f) for f in (face, edit.face)], ["0 %", "100 %"]))
    half = handle_strip(face, replace(edit, share=0.5), drawing, 3)
    assert half.shape[1] > strip.shape[1] and not np.array_equal(half[:, -40:], strip[:, -40:])


def test_labels_before_and_after_or_from_minus_to_plus(pca, face, drawing):
    normal, one = np.eye(len(pca.prior.mean))[:1], np.ones(1)
    directions = Directions(("Smile",), normal, 0 * normal, one, one, 1, one, one, "", {}, normal[:0])
    edit = SemanticEdit(directions, {"Smile": 2.0})
    pair, strip = semantic_strip(face, edit, drawing), semantic_strip(face, edit, drawing, 5)
    assert 2 * pair.shape[1] < strip.shape[1] < 3 * pair.shape[1]
    first = film_strip([drawing.draw(edit_semantic(face, pca, edit.scaled(-1)))], ["-2"])
    np.testing.assert_array_equal(strip[:, : first.shape[1]], first)
    # The last head is the same.
    assert np.array_equal(pair[: 2 * 40, -42:], strip[: 2 * 40, -42:])


def test_degrees_of_a_caricature_after_its_picture(face, edit, drawing):
    degrees = [face, edit.face]
    sheet = caricature_sheet(degrees, [0.0, 1.5], drawing)
    assert np.array_equal(sheet, film_strip([drawing.draw(f) for f in degrees], ["0", "1.5"]))
    portrait = np.full((40, 40, 3), 90, np.uint8)
    given = caricature_sheet(degrees, [0.0, 1.5], drawing, portrait)
    assert given.shape[1] > sheet.shape[1] and (given == 90).all(-1).sum() >= 1600
