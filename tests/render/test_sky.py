import numpy as np

from caricli.render.sky import DIRECTIONS, light_received, sky_visibility


def test_a_sphere_sees_the_whole_sky_and_a_pit_little(sphere):
    vertices, faces = sphere
    free = light_received(sky_visibility(vertices, faces, vertices), vertices, [None])
    assert free.min() > 0.9
    inside_out = light_received(sky_visibility(vertices, faces[:, ::-1], -vertices), -vertices, [None])
    assert inside_out.max() < 0.1


def test_a_wall_shades_from_its_side_only():
    ground = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, -1]])
    wall = np.array([[-0.5, 0, 3], [-0.5, 0, -3], [-0.5, 9, 0]])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    normals = np.array([[0.0, 1, 0]] * 3 + [[1.0, 0, 0]] * 3)
    visibility = sky_visibility(np.concatenate([ground, wall]), faces, normals)
    left, right = np.array([-1, 0.5, 0]) / 1.118, np.array([1, 0.5, 0]) / 1.118
    assert light_received(visibility, normals, [left])[0, 0] < 0.2
    assert light_received(visibility, normals, [right])[0, 0] > 0.95


def test_the_directions_are_even():
    np.testing.assert_allclose(np.linalg.norm(DIRECTIONS, axis=1), 1)
    np.testing.assert_allclose(DIRECTIONS.T @ DIRECTIONS * 3 / len(DIRECTIONS), np.eye(3), atol=0.05)
