from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.interpolate_faces import interpolate_faces
from caricli.structures import Camera, Face, Hair, Mesh


def encoded(vertices, model, **more):
    return encode_face(Face(model.template.with_vertices(vertices), **more), model)


@pytest.fixture(scope="module", params=["pca", "intrinsic"])
def walk(request, strangers):
    """A model and the five faces from one stranger to another, who stands somewhere else."""
    model = request.getfixturevalue(request.param)
    ends = [encoded(vertices, model) for vertices in (strangers[1], strangers[2] + 0.05)]
    return model, list(interpolate_faces(*ends, model, 5))


def test_the_ends_are_the_given_faces(walk, strangers):
    _, faces = walk
    assert len(faces) == 5
    assert np.array_equal(faces[0].vertices, strangers[1]) and np.array_equal(faces[-1].vertices, strangers[2] + 0.05)


def test_latents_run_along_a_line_in_equal_steps(walk):
    _, faces = walk
    latents = np.array([face.latent for face in faces])
    assert np.allclose(np.diff(latents, axis=0), (latents[-1] - latents[0]) / 4)


def test_the_way_is_smooth_and_untorn(walk):
    model, faces = walk
    shapes = np.array([face.vertices for face in faces])
    steps = np.linalg.norm(np.diff(shapes, axis=0), axis=-1)
    assert steps.mean(1).max() < 1.3 * steps.mean(1).min()
    # No vertex jumps: from one step to the next its way bends by less than it goes.
    bends = np.linalg.norm(np.diff(shapes, 2, axis=0), axis=-1)
    assert np.quantile(bends / steps[:-1], 0.99) < 0.5
    flipped = flipped_triangles(shapes, model.template.gradients).mean(1)
    assert flipped.max() <= max(flipped[0], flipped[-1]) + 2e-4


def test_there_and_back_is_the_same_way(pca, strangers):
    ends = [encoded(vertices, pca) for vertices in strangers[:2]]
    there, back = (list(interpolate_faces(*order, pca, 3)) for order in (ends, ends[::-1]))
    assert np.abs(there[1].vertices - back[1].vertices).max() < 1e-9


def test_two_steps_are_the_ends(pca, strangers):
    ends = [encoded(vertices, pca) for vertices in strangers[:2]]
    assert list(interpolate_faces(*ends, pca, 2)) == ends


def test_no_camera_sees_what_is_between(pca, strangers):
    camera = Camera(900.0, np.diag([1.0, -1, -1]), np.ones(2))
    ends = [encoded(vertices, pca, camera=camera, landmarks=np.zeros((68, 2))) for vertices in strangers[:2]]
    walk = list(interpolate_faces(*ends, pca, 3))
    assert all(face.camera is None and face.landmarks is None for face in walk)
    assert walk[0].latent is ends[0].latent and walk[2].mesh is ends[1].mesh


def test_teeth_and_hair_are_worn_on_the_way(pca, strangers):
    first, second = (encoded(vertices, pca) for vertices in strangers[:2])
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    shell = Mesh(square, np.array([[0, 1, 2, 3]]), square[:, :2], np.array([[0, 1, 2, 3]]))
    hair = Hair(shell, np.zeros((4, 3), np.int64), np.full((4, 3), 1 / 3))
    first = replace(first, teeth=np.array([0.002, 0]))
    second = replace(second, teeth=np.array([0.004, 0.001]), hair=hair)
    walk = list(interpolate_faces(first, second, pca, 5))
    np.testing.assert_allclose([face.teeth for face in walk], np.linspace(first.teeth, second.teeth, 5))
    assert [face.hair is not None for face in walk] == [False, True, True, True, True]
    middle = list(interpolate_faces(first, replace(second, teeth=None, hair=None), pca, 3))[1]
    np.testing.assert_array_equal(middle.teeth, first.teeth)
    assert middle.hair is None
