import numpy as np

from caricli.methods.creases.creased_skin import CreasedSkin, CreaseGround
from caricli.methods.creases.relief import Relief
from caricli.methods.texture.estimate_light import harmonics
from caricli.structures import Mesh
from caricli.template.fine_mesh import FineMesh

SIZE = (400, 317)


def sheet():
    """A flat square that looks to the front, twice as wide as the usual face's unit."""
    corners = np.array([[-0.9, -0.9, 0.0], [0.9, -0.9, 0], [0.9, 0.9, 0], [-0.9, 0.9, 0]])
    return FineMesh(Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])), None, 0)


def brightness(slope, way, stain=0.0, turn=None):
    fine = sheet()
    relief = Relief(np.full((*SIZE, 2), slope, np.float32), np.full(SIZE, stain, np.float32))
    turn = np.eye(3) if turn is None else turn
    skin = CreasedSkin.of(CreaseGround(fine, fine.mesh.vertices, -1.0), relief, 0.1 * fine.mesh.vertices @ turn.T, 0.1)
    light = 4 * np.pi * harmonics(np.array([way]) @ turn.T).T @ np.ones((1, 3))
    normals = np.array([[0, 0, 1.0]]) @ turn.T
    return skin.brightness(np.array([0]), np.full((1, 3), 1 / 3), normals, light)[0]


def test_walls_that_face_the_light_are_brighter():
    way = np.array([0.6, 0, 0.8])
    # A height that falls to the right looks to the right.
    assert (brightness((-0.3, 0), way) > 1.05).all()
    assert (brightness((0.3, 0), way) < 0.95).all()
    np.testing.assert_allclose(brightness((0, 0), way), 1)


def test_turning_head_and_light_changes_nothing():
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    way = np.array([0.6, 0, 0.8])
    np.testing.assert_allclose(brightness((0.3, 0.1), way), brightness((0.3, 0.1), way, turn=turn), rtol=1e-4)


def test_the_bottom_of_a_fold_is_darker_and_redder():
    red, green, blue = brightness((0, 0), np.array([0, 0, 1.0]), stain=0.5)
    assert 1 > red > green >= blue
