import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Camera, Face, Mesh

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def full():
    return Face(
        Mesh(VERTICES, FACES),
        Camera(2.5, np.diag([1.0, -1.0, -1.0]), [3.0, 4.0]),
        landmarks=np.arange(136.0).reshape(68, 2),
        latent=np.arange(5.0),
        residual=np.arange(36.0).reshape(4, 9),
        model_id="intrinsic",
    )


def test_a_mesh_is_enough():
    face = Face(Mesh(VERTICES, FACES))
    assert face.camera is face.landmarks is face.latent is face.residual is face.model_id is None


def test_vertices_and_faces_are_the_meshs():
    face = full()
    assert face.vertices is face.mesh.vertices and face.faces is face.mesh.faces


def test_without_latent_nothing_of_the_model_is_left():
    face = full().without_latent()
    assert face.latent is face.residual is face.model_id is None
    np.testing.assert_array_equal(face.landmarks, full().landmarks)
    assert face.camera is not None


def test_what_is_required_is_given_or_named():
    bare = Face(Mesh(VERTICES, FACES))
    for name in ("latent", "camera", "landmarks"):
        assert getattr(full(), f"require_{name}")() is not None
        with pytest.raises(InputError, match=f"expected a face with .*{name}.*, found n"):
            getattr(bare, f"require_{name}")()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"latent": np.zeros((2, 2))}, r"latent: expected the shape \(\*\), found \(2, 2\)"),
        ({"latent": np.zeros(0)}, "latent: expected the shape"),
        ({"teeth": np.zeros(3)}, r"teeth: expected the shape \(2\), found \(3,\)"),
        ({"teeth": np.array([0.01, -0.01])}, "teeth: expected lengths, found -0.01"),
        ({"latent": np.array([1e300])}, "latent: expected finite numbers"),
        ({"latent": np.array([np.nan])}, "latent: expected finite numbers"),
        ({"residual": np.zeros((3, 9))}, r"residual: expected the shape \(4,9\), found \(3, 9\)"),
        ({"residual": np.zeros((4, 8))}, "residual: expected the shape"),
        ({"residual": np.full((4, 9), np.inf)}, "residual: expected finite numbers"),
        ({"landmarks": np.zeros((68, 3))}, r"landmarks: expected the shape \(68,2\) or \(81,2\), found \(68, 3\)"),
        ({"landmarks": np.full((68, 2), np.nan)}, "landmarks: expected finite coordinates"),
        ({"landmarks": np.zeros((0, 2))}, "landmarks: expected the shape"),
    ],
)
def test_parts_that_do_not_fit_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(full(), **changes)


@pytest.mark.parametrize(
    "change",
    [
        lambda face: {"mesh": Mesh(VERTICES * np.nan, FACES)},
        lambda face: {"mesh": Mesh(VERTICES, FACES + 1)},
        lambda face: {"mesh": Mesh(VERTICES, FACES, VERTICES[:, :2])},
        lambda face: {"camera": dataclasses.replace(face.camera, scale=-1.0)},
        lambda face: {"camera": dataclasses.replace(face.camera, rotation=-np.eye(3))},
    ],
)
def test_what_could_not_be_read_back_cannot_be_made(change):
    with pytest.raises(InputError, match="expected"):
        dataclasses.replace(full(), **change(full()))
