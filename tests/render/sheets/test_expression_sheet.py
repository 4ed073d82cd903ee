import numpy as np
import pytest

from caricli.render.sheets import expression_sheet as sheet
from caricli.structures import Mesh, Rig


@pytest.fixture
def rig(ball, monkeypatch):
    """A ball whose mouthClose undoes jawOpen."""
    monkeypatch.setattr(sheet, "SIZE", 32)
    vertices, faces = ball
    deltas = np.zeros((2, 300, 3), np.float32)
    deltas[0, :, 0] = 0.5
    deltas[1, :, 0] = -0.5
    return Rig(("jawOpen", "mouthClose"), Mesh(vertices.astype(np.float32), faces), deltas)


def test_every_expression_is_drawn_on_top_of_what_it_is_meant_for(rig, monkeypatch):
    shapes, done = [], []

    class Stage:
        def __init__(self, rig, view, size):
            self.size = size

        def pictures(self, frames):
            shapes.extend(frames)
            return (np.full((self.size, self.size, 3), 255, np.uint8) for _ in shapes)

    monkeypatch.setattr(sheet, "RigStage", Stage)
    picture = sheet.expression_sheet(rig, lambda k, total: done.append((k, total)), rig.neutral + 1)
    assert picture.ndim == 3 and picture.shape[1] >= 4 * 32 and done == [(1, 4), (2, 4), (3, 4), (4, 4)]
    given, neutral, opened, closed = shapes
    np.testing.assert_allclose(given, rig.neutral + 1)
    np.testing.assert_allclose(closed, neutral, atol=1e-6)
    np.testing.assert_allclose(opened, neutral + [0.5, 0, 0], atol=1e-6)


def test_a_rig_is_drawn(rig):
    picture = sheet.expression_sheet(rig, lambda k, total: None)
    assert picture.shape[1] >= 3 * 32 and picture.shape[1] < 4 * 32 + 32 and (picture < 205).any()
