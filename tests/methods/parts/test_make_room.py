import numpy as np
import pytest

from caricli.methods.parts.make_room import make_room, room_moves

MARGIN = 0.001


class Wall:
    """What is on one side of a plane."""

    def __init__(self, normal, offset):
        self.normal = np.asarray(normal, float) / np.linalg.norm(normal)
        self.offset = offset

    def room(self, points):
        return points @ self.normal - self.offset, np.tile(self.normal, (len(points), 1))


@pytest.fixture
def arch():
    """Columns of five points each, 60 mm across, as crowns stand on an arch."""
    angle = np.linspace(0, np.pi, 29)
    base = np.stack([0.03 * np.cos(angle), np.zeros(29), 0.04 * np.sin(angle)], axis=1)
    return (base[:, None] + np.linspace(0, 0.008, 5)[:, None] * [0, 1, 0]).reshape(-1, 3)


def settled(wall, points, shape=None, turn=None):
    shape = points if shape is None else shape
    moves = room_moves(shape, np.arange(len(shape)))
    moves = moves if turn is None else moves @ turn.T
    return points + moves.transpose(0, 2, 1) @ make_room(wall, points, moves, MARGIN)


def test_what_has_room_stays(arch):
    assert np.array_equal(settled(Wall([0, 0, 1], -0.002), arch), arch)


@pytest.mark.parametrize("normal", [(0, 0, -1), (-1, 0, 0), (1, 0, 0), (-1, 0.3, -0.5)])
def test_what_is_in_the_wall_comes_out_and_the_rest_hardly_moves(arch, normal):
    wall = Wall(normal, 0.0)
    wall.offset = (arch @ wall.normal).min() + 0.004
    after = settled(wall, arch)
    assert wall.room(after)[0].min() > -0.1 * MARGIN
    assert np.linalg.norm(after - arch, axis=1).mean() < 0.5 * 0.005


def test_crowns_keep_their_height_and_stand(arch):
    wall = Wall([0, 0, -1], -0.036)
    columns = settled(wall, arch).reshape(-1, 5, 3)
    crowns = columns[:, -1] - columns[:, 0]
    height = np.linalg.norm(crowns, axis=1)
    assert np.ptp(height) < 1e-3 * 0.008 and 0.9 < height.mean() / 0.008 <= 1.001
    assert np.allclose(crowns, crowns[0], atol=1e-5)


def test_it_turns_and_grows_with_the_head(arch):
    turn = 1.7 * np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    wall = Wall([0, 0.2, -1], -0.035)
    larger = Wall(turn @ wall.normal, 1.7 * wall.offset)
    moves = room_moves(arch, np.arange(len(arch)))
    amounts = make_room(wall, arch, moves, MARGIN)
    turned = make_room(larger, arch @ turn.T, moves @ turn.T, 1.7 * MARGIN)
    assert np.allclose(amounts, turned, atol=1e-9)


def test_a_part_as_large_as_a_room_that_is_too_small_shrinks(arch):
    class Slit:
        """Between two walls that are nearer than the part is wide."""

        def room(self, points):
            side = np.sign(points[:, :1])
            return 0.02 - np.abs(points[:, 0]), -side * [[1.0, 0, 0]]

    after = settled(Slit(), arch)
    assert np.abs(after[:, 0]).max() < 0.0205
