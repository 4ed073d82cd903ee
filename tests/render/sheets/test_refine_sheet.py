import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.sheets.refine_sheet import refine_sheet
from caricli.structures import Camera, Face

CAMERA = Camera(300.0, np.diag([1.0, -1.0, -1.0]), np.array([50.0, 90.0]))


def test_both_faces_with_their_own_landmarks(head_template):
    anchors = head_template.annotation.landmarks[:68]
    given = CAMERA.project(head_template.vertices[anchors])
    longer = head_template.with_vertices(head_template.vertices * [1, 1.3, 1])
    faces = Face(head_template, CAMERA), Face(longer, CAMERA)
    sheet = refine_sheet(faces, anchors, (head_template, longer), given, None, 64).astype(int)
    half = len(sheet) // 2
    assert half > 64 and sheet.shape[1] > 5 * 64
    assert np.abs(sheet[:half] - sheet[-half:]).max() > 50
    same = refine_sheet((faces[0], faces[0]), anchors, (head_template,) * 2, given, None, 64).astype(int)
    np.testing.assert_array_equal(same[:64, 64:], sheet[:64, 64:])


def test_a_face_of_no_picture_is_refused(head_template):
    anchors = head_template.annotation.landmarks[:68]
    with pytest.raises(InputError, match="expected a face with the camera of its picture"):
        refine_sheet((Face(head_template),), anchors, (head_template,), np.zeros((68, 2)), None, 64)


def test_what_was_before_is_above(head_template, monkeypatch):
    told = {}

    def contact_sheet(rows, columns, labels):
        told.update(rows=rows, columns=columns, labels=labels)
        return rows[0]

    monkeypatch.setattr("caricli.render.sheets.refine_sheet.contact_sheet", contact_sheet)
    monkeypatch.setattr("caricli.render.sheets.refine_sheet.fit_sheet", lambda face, head, *_: (face, head))
    anchors = head_template.annotation.landmarks[:68]
    longer = head_template.with_vertices(head_template.vertices * [1, 1.3, 1])
    heads = head_template, longer
    refine_sheet([Face(head, CAMERA) for head in heads], anchors, heads, np.zeros((68, 2)), None, 64)
    assert told["labels"] == ["before", "after"] and told["columns"] == 1
    for (face, head), expected in zip(told["rows"], heads, strict=True):
        assert head is expected
        np.testing.assert_allclose(face.landmarks, CAMERA.project(expected.vertices[anchors]))
