import numpy as np
import pytest

from caricli.methods.hair.sink_rim import sink_rim
from caricli.structures import Hair, Mesh

MM = 0.001


@pytest.fixture
def skin():
    """A square of 20 cm that looks along z, in squares of 1 cm."""
    row, column = (each.ravel() for each in np.mgrid[:20, :20])
    first = row * 21 + column
    y, x = np.mgrid[:21, :21] / 100
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(441)], axis=1)
    return Mesh(vertices, np.stack([first, first + 1, first + 22, first + 21], axis=1))


def hair_at(points):
    """Hair of vertices (H, 3), of which the first three are its triangle."""
    polygons = np.array([[0, 1, 2]])
    count = len(points)
    return Hair(
        Mesh(points, polygons, np.eye(3)[:, :2], polygons), np.zeros((count, 3), int), np.full((count, 3), 1 / 3)
    )


def test_what_expressions_would_uncover_goes_deeper(skin):
    places = np.array([[55, 55, -1], [55, 55, 1], [55, 55, -8], [155, 155, -0.1]]) * MM
    # On the left the skin sinks in two expressions, and rises in another.
    left = skin.vertices[:, 0] < 0.1
    deltas = np.zeros((4, 441, 3))
    deltas[:3, left, 2] = np.array([[-2], [-1], [4]]) * MM
    heights = sink_rim(hair_at(places), skin, deltas).shell.vertices[:, 2]
    # What is outside, deep, or under skin that keeps still, stays.
    np.testing.assert_allclose(heights, np.array([-3.5, 1, -8, -0.1]) * MM, atol=1e-9)


def test_what_moves_along_itself_uncovers_nothing_and_jaws_do_not_push_hair_into_the_mouth(skin):
    hair = hair_at(np.array([[55, 55, -1], [65, 55, -1], [55, 65, -1]]) * MM)
    slid = np.tile([0.004, 0, 0], (1, 441, 1))
    np.testing.assert_array_equal(sink_rim(hair, skin, slid).shell.vertices, hair.shell.vertices)
    opened = np.tile([0, 0, -0.03], (1, 441, 1))
    np.testing.assert_allclose(sink_rim(hair, skin, opened).shell.vertices[:, 2], -6 * MM, atol=1e-9)
