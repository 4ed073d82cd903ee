from dataclasses import replace

import numpy as np

from caricli.render.sheets import driver_sheet as sheet
from caricli.structures import Mesh, Pictures, Rig


def test_both_stand_side_by_side(ball, head_template, monkeypatch):
    monkeypatch.setattr(sheet, "SIZE", 48)
    vertices, faces = ball
    rig = Rig((), Mesh(vertices.astype(np.float32), faces), np.zeros((0, 300, 3), np.float32))
    picture = sheet.driver_sheet(head_template, sheet.driver_stage(rig), rig.face)
    half = picture.shape[1] // 2
    assert half >= 48
    assert (picture[:, :half] < 200).any() and (picture[:, half:] < 200).any()


def test_the_driver_is_on_the_left_and_the_caricature_wears_its_own_skin(ball, head_template, monkeypatch):
    monkeypatch.setattr(sheet, "SIZE", 48)
    monkeypatch.setattr(sheet, "contact_sheet", lambda pictures, columns, labels: (pictures, labels))
    vertices, faces = ball
    blue = Pictures(np.full((4, 4, 3), (20, 40, 220), np.uint8))
    mesh = Mesh(vertices.astype(np.float32), faces, np.full((300, 2), 0.5), faces)
    rig = Rig((), mesh, np.zeros((0, 300, 3), np.float32), pictures=blue)
    green = replace(rig.face, pictures=Pictures(np.full((4, 4, 3), (20, 200, 40), np.uint8)))
    stage = sheet.driver_stage(rig)
    assert sheet.driver_sheet(head_template, stage, green)[0][1][24, 24].argmax() == 1
    pictures, labels = sheet.driver_sheet(head_template, stage, rig.face)
    assert [*labels] == ["driver", "caricature"]
    driver, caricature = pictures
    assert driver[24, 24, 0] > driver[24, 24, 2] and caricature[24, 24, 2] > caricature[24, 24, 0] + 50


def test_a_sheet_is_the_same_whatever_was_drawn_on_its_stage_before(ball, head_template, monkeypatch):
    monkeypatch.setattr(sheet, "SIZE", 48)
    vertices, faces = ball
    rig = Rig((), Mesh(vertices.astype(np.float32), faces), np.zeros((0, 300, 3), np.float32))
    shared = sheet.driver_stage(rig)
    for face in (rig.face.posed(0.7 * vertices), rig.face, rig.face.posed(vertices * [1, 0.5, 1])):
        own = sheet.driver_sheet(head_template, sheet.driver_stage(rig), face)
        np.testing.assert_array_equal(sheet.driver_sheet(head_template, shared, face), own)
