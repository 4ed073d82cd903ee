import numpy as np

from caricli.render.sheets import driver_sheet as sheet
from caricli.structures import Mesh, Rig


def test_both_stand_side_by_side(ball, head_template, monkeypatch):
    monkeypatch.setattr(sheet, "SIZE", 48)
    vertices, faces = ball
    rig = Rig((), Mesh(vertices.astype(np.float32), faces), np.zeros((0, 300, 3), np.float32))
    picture = sheet.driver_sheet(head_template, rig, rig.face)
    half = picture.shape[1] // 2
    assert half >= 48
    assert (picture[:, :half] < 200).any() and (picture[:, half:] < 200).any()
