import numpy as np
import pytest

from caricli.render.sheets import head_sheet as sheet
from caricli.structures import Mesh, Rig


@pytest.fixture
def rig(ball):
    vertices, faces = ball
    names = ("eyeBlinkLeft", "eyeBlinkRight", "jawOpen", "mouthFrown")
    deltas = np.zeros((4, 300, 3), np.float32)
    deltas[range(4), :, [0, 1, 2, 0]] = 1
    return Rig(names, Mesh(vertices.astype(np.float32), faces), deltas)


def test_moods_move_both_sides_by_their_weights_and_leave_what_a_rig_does_not_have(rig):
    moved = sheet._shape(rig, {"eyeBlink": 0.5, "jawOpen": 0.25, "mouthFrown": 2.0, "cheekPuff": 1.0}) - rig.neutral
    np.testing.assert_allclose(moved, np.tile([2.5, 0.5, 0.25], (300, 1)), atol=1e-6)
    np.testing.assert_array_equal(sheet._shape(rig, {"cheekPuff": 1.0}), rig.neutral)


def test_a_row_begins_with_the_picture_and_the_head_as_it_was_drawn(rig, monkeypatch):
    drawn = []

    class Stage:
        def __init__(self, rig, view, size):
            self.rig, self.view, self.size = rig, view, size

        def picture(self, shape):
            drawn.append((self.rig, self.view, shape))
            return np.full((self.size, self.size, 3), 40 * len(drawn), np.uint8)

        def pictures(self, shapes):
            return [self.picture(shape) for shape in shapes]

    monkeypatch.setattr(sheet, "RigStage", Stage)
    first = Rig((), rig.mesh, np.zeros((0, 300, 3), np.float32))
    picture = np.full((60, 60, 3), (10, 60, 250), np.uint8)
    row = sheet.head_sheet(picture, np.array([[15.0, 15], [45, 45]]), first, rig, 24)
    assert [(each is first, view) for each, view, _ in drawn] == [
        (True, "front"), (True, "three-quarter"), *[(False, "front")] * 4,
    ]  # fmt: skip
    assert all(np.array_equal(shape, first.neutral) for _, _, shape in drawn[:2])
    middle = row[len(row) // 2].astype(int)
    places = [(middle == colour).all(1).argmax() for colour in ((10, 60, 250), *range(40, 241, 40))]
    assert places == sorted(places) and len({*places}) == 7
    assert len(row) < 2 * 24 and row.shape[1] > 7 * 24
