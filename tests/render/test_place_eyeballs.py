import numpy as np

from caricli.render.place_eyeballs import place_eyeballs


def edge_path(faces, start, length):
    path = [start]
    while len(path) < length:
        neighbours = np.unique(faces[(faces == path[-1]).any(1)])
        path.append(next(int(n) for n in neighbours if n not in path))
    return path


def tables(faces, shift=0):
    path = [shift + k for k in edge_path(faces, 4, 6)]
    return {"eye_upper_left": path[:3], "eye_lower_left": path[3:]}, {"eye_socket_left": list(range(shift, shift + 50))}


def test_a_ball_fills_its_socket_behind_the_lids(sphere):
    vertices, faces = sphere
    vertices = 0.01 * vertices + [0.03, 0.1, 0.2]
    curves, regions = tables(faces)
    lids = curves["eye_upper_left"] + curves["eye_lower_left"]
    ((centre, radius),) = place_eyeballs(vertices, faces, curves, regions)
    np.testing.assert_allclose(radius, 0.01, rtol=1e-6)
    assert (np.linalg.norm(vertices[lids] - centre, axis=1) > 1.019 * radius).all()
    assert centre[2] < 0.2


def test_follows_a_similarity(sphere):
    vertices, faces = sphere
    curves, regions = tables(faces)
    ((centre, radius),) = place_eyeballs(vertices, faces, curves, regions)
    ((moved, larger),) = place_eyeballs(3 * vertices + [1, 2, 3], faces, curves, regions)
    np.testing.assert_allclose(moved, 3 * centre + [1, 2, 3], atol=1e-9)
    np.testing.assert_allclose(larger, 3 * radius)


def test_another_mesh_and_an_annotation_without_eyes_give_none(sphere):
    vertices, faces = sphere
    curves, regions = tables(faces)
    assert place_eyeballs(vertices, faces, curves, regions)
    assert place_eyeballs(vertices, faces, {}, {}) == []
    assert place_eyeballs(vertices[:4], faces[:0], curves, regions) == []
    far_apart = {"eye_upper_left": [0, 1], "eye_lower_left": [2, 3]}  # the corners of an octahedron: no edges any more
    assert place_eyeballs(vertices, faces, far_apart, regions) == []
