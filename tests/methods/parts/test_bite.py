import numpy as np

from caricli.methods.parts.attachment import open_head_attachment
from caricli.methods.parts.bite import Bite, rows_of_teeth
from caricli.template.head import load_head


class Wall:
    """Behind a depth, across y, nothing may be."""

    def room(self, points):
        return points[:, 2] + 0.02, np.tile([0.0, 0.0, 1.0], (len(points), 1))


def row(height, outwards):
    """Teeth a centimetre high and half a centimetre thick that end at a height."""
    x, y, z = np.meshgrid(np.linspace(-0.02, 0.02, 65), [height, height - 0.01 * outwards], [0.0, 0.005])
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), outwards


def test_what_passes_a_row_of_teeth_does_so_beyond_their_ends():
    points = np.array([[0.0, 0.004, 0.002], [0.01, -0.001, 0.004], [0.0, 0.004, 0.02], [0.03, 0.004, 0.002]])
    upper = Bite(Wall(), [row(0.0, -1)])
    distance, out = upper.room(points)
    np.testing.assert_allclose(distance, [-0.004, 0.001, 0.04, 0.022], atol=1e-12)
    np.testing.assert_array_equal(out, [[0, -1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1]])
    both = Bite(Wall(), [row(0.0, -1), row(-0.002, 1)])
    np.testing.assert_allclose(both.room(points[:2])[0], [-0.004, 0.001], atol=1e-12)
    np.testing.assert_allclose(both.room(points[:1] - [0, 0.008, 0])[0], [-0.002], atol=1e-12)


def test_without_teeth_there_are_walls_alone():
    points = np.random.default_rng(3).normal(size=(9, 3))
    for ours, theirs in zip(Bite(Wall(), []).room(points), Wall().room(points), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_teeth_stand_down_from_the_skull_and_up_from_the_jaw():
    head = load_head()
    parts = open_head_attachment().animate(head.template(), head.action_names, head.actions)
    (upper, down), (lower, up) = rows_of_teeth(parts, head.action_names.index("jawOpen"))
    assert (down, up) == (-1, 1) and upper[:, 1].min() > lower[:, 1].max() + 0.003
