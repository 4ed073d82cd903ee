import igl
import numpy as np

from caricli.geometry.vertex_neighbours import vertex_neighbours


def test_libigl_finds_the_same_neighbours(ball):
    vertices, faces = ball
    adjacency, mean = vertex_neighbours(faces, len(vertices))
    rings = igl.adjacency_list(faces)
    assert [sorted(adjacency[k].indices) for k in range(len(vertices))] == [sorted(ring) for ring in rings]
    assert np.allclose((mean @ vertices)[7], vertices[rings[7]].mean(0))
