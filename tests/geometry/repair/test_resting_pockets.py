from unittest.mock import Mock

import igl
import numpy as np
import pytest

from caricli.geometry.repair.resting_pockets import RestingPockets
from caricli.geometry.repair.tuck_cavities import Cavities
from caricli.methods.rig.head_expressions import open_head_expressions


@pytest.fixture(scope="module")
def templates():
    return open_head_expressions()


def outgrown(templates, k, weight):
    """The head with so much of an expression that pockets may come out, and its nose pressed in."""
    vertices = templates.neutral + weight * templates.deltas[k]
    nose = vertices[templates.mesh.annotation.landmarks[33]]
    skin = np.setdiff1d(np.arange(len(vertices)), templates.mesh.region("inner_mouth"))
    vertices[skin, 2] -= 0.02 * np.exp(-(((vertices[skin] - nose) / 0.012) ** 2).sum(1))
    return vertices


@pytest.mark.parametrize("pressed", [False, True])
def test_what_is_not_looked_at_has_not_come_out(templates, pressed):
    cavities = templates.mesh.cavities
    rest = outgrown(templates, 0, 0.0) if pressed else templates.neutral
    pockets = RestingPockets(cavities, rest)
    came_out = 0
    for k in map(templates.names.index, ("eyeBlinkLeft", "mouthSmileRight", "mouthPucker")):
        for vertices in (rest + 2 * templates.deltas[k], outgrown(templates, k, 1.5)):
            whole = cavities.withdraw(vertices)
            came_out += not np.array_equal(whole, vertices)
            np.testing.assert_array_equal(pockets.withdraw(vertices), whole)
    assert came_out >= 3


def test_most_of_what_keeps_still_is_not_looked_at(templates, monkeypatch):
    cavities = templates.mesh.cavities
    pockets = RestingPockets(cavities, templates.neutral)
    asked = []

    def withdraw(vertices, spots, solid):
        asked.append(spots.mean())
        return vertices

    monkeypatch.setattr(cavities, "withdraw", withdraw)
    for delta in templates.deltas:
        pockets.withdraw(templates.neutral + delta)
    assert np.mean(asked) < 0.25


def test_skin_whose_pockets_stay_inside_is_closed_once(templates, monkeypatch):
    cavities = templates.mesh.cavities
    pockets = RestingPockets(cavities, templates.neutral)
    closed = Mock(wraps=cavities.closed)
    monkeypatch.setattr(cavities, "closed", closed)
    assert np.array_equal(pockets.withdraw(templates.neutral), templates.neutral) and closed.call_count == 1


def test_without_pockets_nothing_moves(templates):
    without = Cavities(templates.neutral, templates.mesh.faces, [])
    moved = 1.5 * templates.neutral
    assert np.array_equal(RestingPockets(without, templates.neutral).withdraw(moved), moved)


def test_gaps_are_at_most_the_distances(ball):
    """Of points right above the middles of triangles, far from all corners."""
    vertices, faces = ball
    pockets = RestingPockets(Cavities(vertices, faces, [np.flatnonzero(vertices[:, 2] > 0.6)]), vertices)
    points = 1.01 * pockets.closed[pockets.surface[::7]].mean(1)
    distances = [
        np.sqrt(igl.point_mesh_squared_distance(points, pockets.closed, triangle[None])[0].min())
        for triangle in pockets.surface
    ]
    assert (pockets._gaps(points) <= np.array(distances) + 1e-12).all()
