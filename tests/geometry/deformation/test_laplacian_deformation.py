import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation

ANCHORS = np.array([0, 8, 31, 40, 54, 62])
KINDS = ("uniform", "cotangent")


def targets(vertices, size=0.2, seed=0):
    return vertices[ANCHORS] + size * np.random.default_rng(seed).normal(size=(len(ANCHORS), 3))


def slow_weights(vertices, faces, laplacian):
    """(V, V) of the edges: one, or the cotangents of the angles that face them, far from zero."""
    weights = np.zeros((len(vertices), len(vertices)))
    for triangle in faces:
        for a, b, c in (np.roll(triangle, k) for k in range(3)):
            one, other = vertices[b] - vertices[a], vertices[c] - vertices[a]
            weights[b, c] += one @ other / np.linalg.norm(np.cross(one, other)) / 2
    weights += weights.T
    usual = np.median(weights[weights > 0])
    return np.where(weights == 0, 0, 1 if laplacian == "uniform" else np.maximum(weights, 0.01 * usual))


@pytest.mark.parametrize("laplacian", KINDS)
@pytest.mark.parametrize("name", ["patch", "ball", "both"])
@pytest.mark.parametrize("weight", [0.3, 50.0])
def test_it_is_the_least_squares_of_equation_10(name, weight, laplacian, patch, ball):
    vertices, faces = ball if name == "ball" else patch
    anchors = ANCHORS
    if name == "both":
        anchors = np.append(ANCHORS, len(vertices) + np.array([5, 70]))
        vertices, faces = np.vstack([vertices, ball[0] + 4]), np.vstack([faces, ball[1] + len(vertices)])
    wanted = vertices[anchors] + 0.2 * np.random.default_rng(0).normal(size=(len(anchors), 3))
    weights = slow_weights(vertices, faces, laplacian)
    matrix = np.identity(len(vertices)) - weights / weights.sum(1, keepdims=True)
    pick = np.eye(len(vertices))[anchors] * np.sqrt(weight)

    def dense(detail):
        right = np.vstack([detail, np.sqrt(weight) * wanted])
        return np.linalg.lstsq(np.vstack([matrix, pick]), right, rcond=None)[0]

    deformation, slow = LaplacianDeformation(vertices, faces, anchors, weight, laplacian), dense(matrix @ vertices)
    np.testing.assert_allclose(deformation.move(wanted, rounds=0), slow, atol=1e-8)
    turns = [
        Rotation.align_vectors(slow[ring > 0] - slow[i], vertices[ring > 0] - vertices[i], ring[ring > 0])[0]
        for i, ring in enumerate(weights)
    ]
    slow = dense(np.stack([turn.apply(own) for turn, own in zip(turns, matrix @ vertices, strict=True)]))
    np.testing.assert_allclose(deformation.move(wanted, rounds=1), slow, atol=1e-7)


@pytest.mark.parametrize("laplacian", KINDS)
def test_anchors_that_stay_move_nothing(patch, laplacian):
    vertices, faces = patch
    before = vertices.copy()
    found = LaplacianDeformation(vertices, faces, ANCHORS, 1.0, laplacian).move(vertices[ANCHORS])
    np.testing.assert_allclose(found, vertices, atol=1e-10)
    np.testing.assert_array_equal(vertices, before)


@pytest.mark.parametrize("laplacian", KINDS)
def test_a_rigid_motion_of_everything_moves_the_result_alike(ball, laplacian):
    vertices, faces = ball
    turn = rotation_matrices(np.array([[0.4, -1.0, 0.7]]))[0].T
    wanted = targets(vertices)
    here = LaplacianDeformation(vertices, faces, ANCHORS, 1.0, laplacian).move(wanted)
    there = LaplacianDeformation(vertices @ turn + 3.0, faces, ANCHORS, 1.0, laplacian).move(wanted @ turn + 3.0)
    np.testing.assert_allclose(there, here @ turn + 3.0, atol=1e-8)
    # Mirrored too: no rotation may turn into a reflection.
    flip = np.array([-1.0, 1, 1])
    mirrored = LaplacianDeformation(vertices * flip, faces[:, ::-1], ANCHORS, 1.0, laplacian).move(wanted * flip)
    np.testing.assert_allclose(mirrored, here * flip, atol=1e-8)


@pytest.mark.parametrize("laplacian", KINDS)
def test_anchors_that_turn_take_the_surface_along_as_it_is(patch, laplacian):
    vertices, faces = patch
    turned = vertices @ rotation_matrices(np.radians([[40.0, 0, 30.0]]))[0].T
    deformation = LaplacianDeformation(vertices, faces, ANCHORS, 10.0, laplacian)
    errors = [np.abs(deformation.move(turned[ANCHORS], rounds) - turned).max() for rounds in (0, 4, 20, 400)]
    assert (np.diff(errors) < 0).all() and errors[2] < 0.2 * errors[0] and errors[3] < 1e-8, errors


@pytest.mark.parametrize("laplacian", KINDS)
def test_a_larger_weight_comes_nearer(patch, laplacian):
    vertices, faces = patch
    wanted, gaps = targets(vertices), []
    for weight in (0.01, 1.0, 100.0, 1e4):
        found = LaplacianDeformation(vertices, faces, ANCHORS, weight, laplacian).move(wanted)
        gaps.append(np.abs(found[ANCHORS] - wanted).max())
    assert (np.diff(gaps) < 0).all() and gaps[-1] < 1e-3, gaps


def test_triangles_without_area_are_refused_where_angles_count(patch):
    vertices, faces = patch
    pinched = vertices.copy()
    pinched[1] = pinched[0]
    with pytest.raises(NumericsError, match="with an area"):
        LaplacianDeformation(pinched, faces, ANCHORS, 1.0, "cotangent")
    found = LaplacianDeformation(pinched, faces, ANCHORS, 1.0, "uniform").move(targets(pinched))
    assert np.isfinite(found).all()
