import igl
import numpy as np

from caricli.geometry.vertex_neighbours import vertex_neighbours


def test_libigl_finds_the_same_neighbours(ball):
    vertices, faces = ball
    adjacency, mean = vertex_neighbours(faces, len(vertices))
    rings = igl.adjacency_list(faces)
    assert [sorted(adjacency[k].indices) for k in range(len(vertices))] == [sorted(ring) for ring in rings]
    assert np.allclose((mean @ vertices)[7], vertices[rings[7]].mean(0))


def test_at_a_border_an_edge_of_one_triangle_joins_its_ends_both_ways():
    adjacency, mean = vertex_neighbours(np.array([[0, 1, 2], [2, 1, 3]]), 4)
    expected = np.array([[0, 1, 1, 0], [1, 0, 1, 1], [1, 1, 0, 1], [0, 1, 1, 0]], float)
    np.testing.assert_array_equal(adjacency.toarray(), expected)
    np.testing.assert_allclose(mean.toarray(), expected / expected.sum(1, keepdims=True))
