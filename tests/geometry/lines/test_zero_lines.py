import numpy as np
import pytest

from caricli.geometry.lines.zero_lines import zero_lines


def test_a_plane_cuts_a_ball_in_one_closed_ring(ball):
    vertices, faces = ball
    values = vertices @ [0.2, 0.1, 1.0] - 0.3
    (ring,) = zero_lines(values, faces)
    np.testing.assert_array_equal(ring.ends[0], ring.ends[-1])
    np.testing.assert_allclose(ring.of(values), 0, atol=1e-12)
    points = ring.of(vertices)
    np.testing.assert_allclose(points @ [0.2, 0.1, 1.0], 0.3)
    assert (ring.share >= 0).all() and (ring.share <= 1).all()
    above = values[faces] >= 0
    assert len(points) - 1 == (above.any(1) & ~above.all(1)).sum()
    # Steps within one triangle are no longer than its edges.
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.35
    np.testing.assert_array_equal(ring.part(2, 5).of(vertices), points[2:5])


def test_two_planes_cut_it_in_two(ball):
    vertices, faces = ball
    assert len(zero_lines(np.abs(vertices[:, 2]) - 0.5, faces)) == 2


def test_a_line_ends_where_the_mesh_does_and_none_is_of_one_sign():
    strip = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4]])
    (line,) = zero_lines(np.array([-1.0, 3.0, -1.0, 1.0, -3.0]), strip)
    ends = sorted(map(tuple, line.ends[[0, -1]].tolist()))
    assert ends == [(0, 1), (3, 4)] and len(line.share) == 4
    expected = {(0, 1): 0.25, (1, 2): 0.75, (2, 3): 0.5, (3, 4): 0.25}
    assert {tuple(edge): share for edge, share in zip(line.ends.tolist(), line.share.tolist(), strict=True)} == expected
    for values in (np.ones(5), -np.ones(5), np.array([1.0, 0, 0, 2, 3])):
        assert zero_lines(values, strip) == []


@pytest.mark.parametrize("seed", range(4))
def test_a_line_is_whole_whatever_the_numbers_of_the_vertices(patch, seed):
    vertices, faces = patch
    order = np.random.default_rng(seed).permutation(len(vertices))
    mixed = np.argsort(order)[faces]
    values = (vertices @ [1.0, 0.3, 0] - 0.9)[order]
    (line,) = zero_lines(values, mixed)
    above = values[mixed] >= 0
    assert len(line.share) - 1 == (above.any(1) & ~above.all(1)).sum()


def test_an_exact_zero_counts_as_positive():
    (line,) = zero_lines(np.array([-1.0, 0.0, 1.0]), np.array([[0, 1, 2]]))
    assert {tuple(edge): share for edge, share in zip(line.ends.tolist(), line.share.tolist(), strict=True)} == {
        (0, 1): 1.0,
        (0, 2): 0.5,
    }
