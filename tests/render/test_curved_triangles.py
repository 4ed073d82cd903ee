import numpy as np

from caricli.render.curved_triangles import curved_triangles, split_long_edges
from caricli.render.smooth_normals import smooth_normals


def test_a_sphere_becomes_rounder_and_keeps_its_vertices(sphere):
    vertices, faces = sphere
    finer, triangles, normals, (carried,) = curved_triangles(vertices, faces, vertices, [vertices[:, 0]])
    new = np.linalg.norm(finer[len(vertices) :], axis=1)
    flat = np.linalg.norm((vertices[faces[:, 0]] + vertices[faces[:, 1]]) / 2, axis=1)
    assert np.abs(new - 1).max() < 0.2 * np.abs(flat - 1).max()
    assert (finer[: len(vertices)] == vertices).all() and len(triangles) == 4 * len(faces)
    assert (smooth_normals(finer, triangles) * normals).sum(1).min() > 0.99
    assert len(carried) == len(finer) == len(vertices) + 3 * len(faces) // 2


def test_a_crease_and_a_plane_stay_straight():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    up = np.tile([0.0, 0, 1], (4, 1))
    sharp = np.array([[0, 0, 1.0], [1, 0, 0], [0, 0, 1], [1, 0, 0]])
    for normals in (up, sharp):
        finer = curved_triangles(square, np.array([[0, 1, 2], [0, 2, 3]]), normals)[0]
        edges = {(tuple(p)) for p in finer[4:]}
        assert {(0.5, 0, 0), (1, 0.5, 0), (0, 0.5, 0)} <= edges


def test_edges_are_split_until_they_are_short_in_the_picture(sphere):
    """Depth does not count, and a mesh does not become finer than it is worth to draw."""
    vertices, faces = sphere
    flat = np.tile([0.0, 0, 1], (len(vertices), 1))
    for size in (40, 100, 200):
        shallow, deep = (
            split_long_edges(vertices * [size, size, depth], faces, flat, [vertices], 12.0) for depth in (1, 4000)
        )
        points, triangles, normals, (carried,) = shallow
        edges = np.linalg.norm(np.diff(points[triangles][:, [0, 1, 2, 0], :2], axis=1), axis=2)
        assert np.quantile(edges, 0.9) <= 12 and len(points) == len(normals) == len(carried)
        assert len(deep[1]) == len(triangles)
    assert len(split_long_edges(1e5 * vertices, faces, vertices, [], 12.0)[1]) <= 150_000


def test_an_edge_between_opposite_normals_has_a_normal_of_no_length():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]])
    normals = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0, 1]])
    finer = curved_triangles(square, np.array([[0, 1, 2]]), normals)
    assert np.isfinite(finer[0]).all() and np.isfinite(finer[2]).all()
