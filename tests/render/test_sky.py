import numpy as np

from caricli.render.sky import DIRECTIONS, key_directions, light_received, sky_visibility


def test_a_sphere_sees_the_whole_sky_and_a_pit_little(sphere):
    vertices, faces = sphere
    free = light_received(sky_visibility(vertices, faces, vertices), vertices, DIRECTIONS, [None])
    assert free.min() > 0.9
    inside_out = light_received(sky_visibility(vertices, faces[:, ::-1], -vertices), -vertices, DIRECTIONS, [None])
    assert inside_out.max() < 0.1


def test_a_wall_shades_from_its_side_only():
    ground = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, -1]])
    wall = np.array([[-0.5, 0, 3], [-0.5, 0, -3], [-0.5, 9, 0]])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    normals = np.array([[0.0, 1, 0]] * 3 + [[1.0, 0, 0]] * 3)
    visibility = sky_visibility(np.concatenate([ground, wall]), faces, normals)
    left, right = np.array([-1, 0.5, 0]) / 1.118, np.array([1, 0.5, 0]) / 1.118
    assert light_received(visibility, normals, DIRECTIONS, [left])[0, 0] < 0.2
    assert light_received(visibility, normals, DIRECTIONS, [right])[0, 0] > 0.95


def test_the_directions_are_even():
    np.testing.assert_allclose(np.linalg.norm(DIRECTIONS, axis=1), 1)
    np.testing.assert_allclose(DIRECTIONS.T @ DIRECTIONS * 3 / len(DIRECTIONS), np.eye(3), atol=0.05)


def test_a_light_is_a_cone_about_its_way():
    way = np.array([-0.6, 0.0, -0.8])
    rays = key_directions(way)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1)
    np.testing.assert_allclose(rays.mean(0) / np.linalg.norm(rays.mean(0)), way, atol=0.02)
    assert 0.92 < (rays @ way).min() < 0.98
