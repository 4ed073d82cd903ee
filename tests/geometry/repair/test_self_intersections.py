import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.repair import self_intersections as module
from caricli.geometry.repair.self_intersections import self_intersections

ACROSS = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0], [0, -0.2, -1], [0.2, 0, 1], [-0.2, 0, 1]])
FACES = np.array([[0, 1, 2], [3, 4, 5]])


def test_triangles_that_cross_are_found_wherever_they_are():
    assert self_intersections(ACROSS, FACES).tolist() == [[0, 1]]
    turned = 1e-3 * ACROSS @ rotation_matrices(np.array([0.3, -1.0, 0.7])) + [5.0, 2, 1]
    assert self_intersections(turned, FACES[::-1]).tolist() == [[0, 1]]


@pytest.mark.parametrize("shift", [[0, 0, 1.1], [3, 0, 0], [0, -1.5, 0]])
def test_triangles_apart_are_not(shift):
    assert len(self_intersections(np.vstack([ACROSS[:3], ACROSS[3:] + shift]), FACES)) == 0


def test_long_triangles_are_found_where_they_are_thin():
    long = np.array([[0.0, 0, 0], [0, 0.02, 0], [9, 0.01, 0]])
    for x in (0.3, 8.5):
        small = np.array([[x, 0.01, -0.1], [x + 0.2, 0.01, 0.3], [x - 0.2, 0.01, 0.3]])
        assert self_intersections(np.vstack([long, small]), FACES).tolist() == [[0, 1]]
        assert self_intersections(np.vstack([small, long]), FACES).tolist() == [[0, 1]]


def test_a_sphere_has_none_until_its_pole_is_pushed_through_the_other(ball):
    vertices, faces = ball
    assert len(self_intersections(vertices, faces)) == 0
    pushed = vertices.copy()
    pushed[np.argmax(vertices[:, 2])] *= [1, 1, -1.5]
    pairs = self_intersections(pushed, faces)
    assert len(pairs)
    moved = (faces == np.argmax(vertices[:, 2])).any(1)
    assert moved[pairs].any(1).all()
    assert (pairs[:, 0] < pairs[:, 1]).all()


def test_slow_twin_agrees(ball):
    """A sphere that is squashed at random: every pair of triangles, every edge, by solving for the crossing."""
    vertices, faces = ball
    bent = vertices + 0.4 * np.random.default_rng(0).normal(size=vertices.shape)
    keep = faces[:120]
    expected = []
    for i in range(len(keep)):
        for j in range(i):
            if set(keep[i]) & set(keep[j]):
                continue
            if any(crosses(bent[keep[x]], bent[keep[y]]) for x, y in ((i, j), (j, i))):
                expected.append([j, i])
    assert self_intersections(bent, keep).tolist() == sorted(expected)
    assert len(expected) > 20


def crosses(triangle, other):
    for k in range(3):
        start, end = triangle[k], triangle[(k + 1) % 3]
        columns = np.stack([start - end, other[1] - other[0], other[2] - other[0]], axis=1)
        t, u, v = np.linalg.solve(columns, start - other[0])
        if 0 < t < 1 and u > 0 and v > 0 and u + v < 1:
            return True
    return False


def test_a_mesh_in_one_place_asks_for_no_memory(ball):
    vertices, faces = ball
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "MAX_PAIRS", 100 * len(faces))
        assert len(self_intersections(vertices, faces)) == 0
        for heap in (0 * vertices, np.where(vertices[:, :1] > 0.9, vertices, 0.1)):
            with pytest.raises(NumericsError, match="expected a surface, found [0-9]+ pairs of triangles in one place"):
                self_intersections(heap, faces)


def test_blocks_make_no_difference(ball, monkeypatch):
    vertices, faces = ball
    crumpled = vertices + np.random.default_rng(5).normal(0, 0.2, vertices.shape)
    whole = self_intersections(crumpled, faces)
    monkeypatch.setattr(module, "_BLOCK", 7)
    np.testing.assert_array_equal(self_intersections(crumpled, faces), whole)
    assert len(whole) > 100


def test_triangles_of_a_mesh_that_is_split_at_seams_meet_where_they_would(ball):
    vertices, faces = ball
    turned = vertices @ rotation_matrices(np.array([[0.3, -0.5, 0.9]]))[0].T
    apart = turned[faces].reshape(-1, 3)
    assert len(self_intersections(apart, np.arange(len(apart)).reshape(-1, 3))) == 0
