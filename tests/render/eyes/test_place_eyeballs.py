from dataclasses import replace

import numpy as np
import pytest

from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.structures import Mesh


def edge_path(faces, start, length):
    path = [start]
    while len(path) < length:
        neighbours = np.unique(faces[(faces == path[-1]).any(1)])
        path.append(next(int(n) for n in neighbours if n not in path))
    return path


@pytest.fixture
def one_eye(sphere, bare):
    path = np.array(edge_path(sphere[1], 4, 6))
    curves = {"eye_upper_left": path[:3], "eye_lower_left": path[3:]}
    return replace(bare, curves=curves, regions={"eye_socket_left": np.arange(50)})


def test_a_ball_fills_its_socket_behind_the_lids(sphere, one_eye):
    vertices, faces = sphere
    vertices = 0.01 * vertices + [0.03, 0.1, 0.2]
    lids = np.concatenate([one_eye.curves["eye_upper_left"], one_eye.curves["eye_lower_left"]])
    ((centre, radius),) = place_eyeballs(Mesh(vertices, faces), one_eye)
    np.testing.assert_allclose(radius, 0.01, rtol=1e-6)
    assert (np.linalg.norm(vertices[lids] - centre, axis=1) > 1.019 * radius).all()
    assert centre[2] < 0.2


def test_follows_a_similarity(sphere, one_eye):
    vertices, faces = sphere
    ((centre, radius),) = place_eyeballs(Mesh(vertices, faces), one_eye)
    ((moved, larger),) = place_eyeballs(Mesh(3 * vertices + [1, 2, 3], faces), one_eye)
    np.testing.assert_allclose(moved, 3 * centre + [1, 2, 3], atol=1e-9)
    np.testing.assert_allclose(larger, 3 * radius)


def test_another_mesh_and_an_annotation_without_eyes_give_none(sphere, bare, one_eye):
    mesh = Mesh(*sphere)
    assert place_eyeballs(mesh, one_eye)
    assert place_eyeballs(mesh, bare) == []
    assert place_eyeballs(Mesh(sphere[0][:4], np.array([[0, 1, 2]])), one_eye) == []
    # The corners of an octahedron: no edges any more.
    far_apart = {"eye_upper_left": np.array([0, 1]), "eye_lower_left": np.array([2, 3])}
    assert place_eyeballs(mesh, replace(one_eye, curves=far_apart)) == []


def test_a_mesh_with_its_own_eyes_gets_none(sphere, one_eye):
    regions = one_eye.regions | {"eyeball_left": np.arange(3)}
    assert place_eyeballs(Mesh(*sphere), replace(one_eye, regions=regions)) == []


def test_a_socket_with_one_vertex_too_many_is_of_another_mesh(sphere, one_eye):
    regions = {"eye_socket_left": np.arange(len(sphere[0]) + 1)}
    assert place_eyeballs(Mesh(*sphere), replace(one_eye, regions=regions)) == []


def test_lids_may_be_borders_in_either_direction(sphere, one_eye):
    vertices, faces = sphere
    upper = one_eye.curves["eye_upper_left"]
    for lid in (upper, upper[::-1]):
        pairs = {tuple(pair) for pair in np.stack([lid[:-1], lid[1:]], 1).tolist()}
        edges = faces[:, [[0, 1], [1, 2], [2, 0]]].tolist()
        open_mesh = faces[[not pairs & {tuple(edge) for edge in face} for face in edges]]
        assert len(open_mesh) < len(faces) and len(place_eyeballs(Mesh(vertices, open_mesh), one_eye)) == 1
