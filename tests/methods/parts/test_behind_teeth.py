from dataclasses import replace

import numpy as np

from caricli.methods.parts.behind_teeth import behind_teeth
from caricli.structures import Material, Mesh, Part

HEIGHT = 0.25


def part(name, hangs_on, material, vertices):
    vertices = np.asarray(vertices, float)
    faces = np.array([[k, k + 1, k + 2] for k in range(len(vertices) - 2)])
    return Part(
        name, Mesh(vertices, faces), np.full(len(faces), material), hangs_on, (), np.zeros((0, *vertices.shape))
    )


def arch():
    return part("upper", "skull", Material.TEETH, [[x, y, 0.1] for x in (-2e-3, 0, 2e-3) for y in (-2e-3, 2e-3)])


def tongue(tip):
    return part("tongue", "jaw", Material.TONGUE, [[0, 0, z] for z in np.linspace(0.05, tip, 9)])


def test_a_tongue_through_the_teeth_goes_behind_them_and_its_root_stays():
    rest, moved = tongue(0.108), behind_teeth((arch(), tongue(0.108)), HEIGHT)[1]
    assert moved.mesh.vertices[:, 2].max() < 0.0995
    np.testing.assert_array_equal(moved.mesh.vertices[0], rest.mesh.vertices[0])
    assert (np.diff(moved.mesh.vertices[:, 2]) > 0).all()


def test_a_tongue_that_has_room_stays():
    for parts in ((arch(), tongue(0.09)), (tongue(0.108),), (replace(arch(), hangs_on="jaw"), tongue(0.108))):
        moved = behind_teeth(parts, HEIGHT)
        np.testing.assert_array_equal(moved[-1].mesh.vertices, parts[-1].mesh.vertices)
