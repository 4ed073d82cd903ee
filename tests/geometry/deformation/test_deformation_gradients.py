from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from caricli.data.identities import random_identity
from caricli.errors import NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.structures.face import FEATURES

VECTORS = arrays(float, 3, elements=st.floats(-1.8, 1.8))


def centred(vertices):
    return vertices - vertices.mean(-2, keepdims=True)


def bent(vertices, generator):
    """A smooth deformation with rotation and stretch everywhere."""
    wave = np.sin(vertices @ generator.normal(size=(3, 3)) + generator.normal(size=3))
    turned = vertices @ Rotation.random(random_state=int(generator.integers(1000))).as_matrix().T
    return turned + 0.3 * wave + generator.normal(size=3)


def cotangent_weights(vertices, faces):
    weights = np.zeros((len(vertices), len(vertices)))
    for face in faces:
        for k in range(3):
            a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            u, v = vertices[b] - vertices[a], vertices[c] - vertices[a]
            weights[b, c] += u @ v / np.linalg.norm(np.cross(u, v)) / 2
    weights = weights + weights.T
    return np.where(weights != 0, np.maximum(weights, 1e-3), 0.0)


def dense_planes(vertices, faces):
    """Per vertex: tangents (3, 2), their weights (2,), and the rows (2, V) of the linear fit, by np.linalg.lstsq."""
    weights = cotangent_weights(vertices, faces)
    planes = []
    for i in range(len(vertices)):
        ring = np.flatnonzero(weights[i])
        edges, root = vertices[ring] - vertices[i], np.sqrt(weights[i, ring])
        extent, axes = np.linalg.eigh(edges.T @ (weights[i, ring, None] * edges))
        difference = np.zeros((len(ring), len(vertices)))
        difference[np.arange(len(ring)), ring] = 1
        difference[:, i] = -1
        rows = np.linalg.lstsq(root[:, None] * (edges @ axes[:, 1:]), root[:, None] * difference, rcond=None)[0]
        planes.append((axes[:, 1:], extent[1:], rows))
    return planes


@pytest.mark.parametrize("mesh", ["ball", "patch"])
def test_shapes_survive_the_features_also_batched(mesh, request):
    gradients = request.getfixturevalue(f"{mesh}_gradients")
    generator = np.random.default_rng(0)
    shapes = np.array([[bent(gradients.template, generator) for _ in range(3)] for _ in range(2)])
    before = shapes.copy()
    features = gradients.features(shapes)
    assert features.shape == (2, 3, gradients.count, FEATURES)
    decoded = gradients.vertices(features)
    assert np.abs(decoded - centred(shapes)).max() < 1e-6 * np.ptp(shapes[0, 0])
    assert np.abs(gradients.features(decoded) - features).max() < 1e-6
    assert np.array_equal(shapes, before)
    for k in np.ndindex(2, 3):
        assert np.allclose(features[k], gradients.features(shapes[k]), atol=1e-12)
        assert np.allclose(decoded[k], gradients.vertices(features[k]), atol=1e-12)


def test_heads_survive_the_features(head, head_template, people):
    gradients = head_template.gradients
    shapes = np.concatenate([people[:6], [head.evaluate(actions={"jawOpen": 1.0, "mouthPucker": 0.6})]])
    features = gradients.features(shapes)
    decoded = gradients.vertices(features)
    assert np.abs(decoded - centred(shapes)).max() < 1e-7 * head_template.height
    assert np.abs(gradients.features(decoded) - features).max() < 1e-6


def test_the_template_has_no_features(ball_gradients):
    assert np.abs(ball_gradients.features(ball_gradients.template)).max() < 1e-8


@settings(max_examples=40, deadline=None, derandomize=True)
@given(vector=VECTORS, shift=VECTORS)
def test_a_rigid_motion_turns_the_rotations_and_nothing_else(ball_gradients, vector, shift):
    rotation = Rotation.from_rotvec(vector)
    shape = bent(ball_gradients.template, np.random.default_rng(1))
    moved = shape @ rotation.as_matrix().T + shift
    features, turned = ball_gradients.features(shape), ball_gradients.features(moved)
    assert np.abs(turned[:, 3:] - features[:, 3:]).max() < 1e-8
    expected = rotation.as_matrix() @ rotation_matrices(features[:, :3])
    assert np.abs(rotation_matrices(turned[:, :3]) - expected).max() < 1e-8
    assert np.abs(ball_gradients.vertices(turned) - centred(moved)).max() < 1e-6


def test_features_that_are_turned_decode_to_the_turned_shape(ball_gradients):
    rotation = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    features = np.random.default_rng(2).normal(0, 0.2, (ball_gradients.count, FEATURES))
    turned = features.copy()
    turned[:, :3] = Rotation.from_matrix(rotation @ rotation_matrices(features[:, :3])).as_rotvec()
    expected = ball_gradients.vertices(features) @ rotation.T
    assert np.abs(ball_gradients.vertices(turned) - expected).max() < 1e-8


@pytest.mark.parametrize("scale", [0.25, 1.0, 3.0])
def test_uniform_scaling_is_pure_stretch(patch_gradients, scale):
    features = patch_gradients.features(scale * patch_gradients.template)
    assert np.abs(features[:, :3]).max() < 1e-8
    assert np.abs(features[:, 3:6] - (scale - 1)).max() < 1e-8
    assert np.abs(features[:, 6:]).max() < 1e-8


def test_a_dense_fit_of_every_ring_agrees(patch, patch_gradients):
    shape = bent(patch[0], np.random.default_rng(3))
    maps, features = patch_gradients.maps(shape), patch_gradients.features(shape)
    for i, (tangents, _, rows) in enumerate(dense_planes(*patch)):
        mapped = (rows @ shape).T
        normal, template_normal = np.cross(*mapped.T), np.cross(*tangents.T)
        expected = mapped @ tangents.T + np.outer(normal / np.sqrt(np.linalg.norm(normal)), template_normal)
        assert np.allclose(maps[i], expected, atol=1e-9)
        rotation, stretch = polar(expected)
        assert np.allclose(rotation_matrices(features[i, :3]), rotation, atol=1e-8)
        symmetric = [stretch[k] - (k[0] == k[1]) for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        assert np.allclose(features[i, 3:], symmetric, atol=1e-8)
    assert np.allclose(patch_gradients.features_to_maps(features), maps, atol=1e-8)


def test_a_dense_solve_of_the_energy_agrees(patch, patch_gradients):
    """For features that no shape has, where the solution is a compromise."""
    features = np.random.default_rng(4).normal(0, 0.3, (len(patch[0]), FEATURES))
    maps = patch_gradients.features_to_maps(features)
    rows, right = [], []
    for (tangents, extent, fit), linear in zip(dense_planes(*patch), maps, strict=True):
        rows.append(np.sqrt(extent)[:, None] * fit)
        right.append(np.sqrt(extent)[:, None] * (linear @ tangents).T)
    expected = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=1e-10)[0]
    solved = patch_gradients.maps_to_vertices(maps)
    assert np.abs(solved - centred(expected)).max() < 1e-6 * np.ptp(expected)
    assert np.abs(patch_gradients.maps(solved) - maps).max() > 0.05


def test_a_ring_without_extent_has_finite_features(patch, patch_gradients):
    flat, point = patch[0] * [1, 0, 0], patch[0] * 0
    for shape in (flat, point):
        features = patch_gradients.features(shape)
        assert np.isfinite(features).all()
        assert np.abs(patch_gradients.vertices(features) - centred(shape)).max() < 1e-6


@pytest.mark.parametrize(("strength", "allowed"), [(0.5, 0.0), (1.0, 0.003)])
def test_between_two_faces_no_more_triangles_are_flipped_than_at_the_worse_end(head, head_template, strength, allowed):
    """Strong identities have rings at the nostrils and lids that are all but turned over; there a few may follow."""
    gradients, generator = head_template.gradients, np.random.default_rng(6)
    actions = ({}, {"jawOpen": 0.9, "browInnerUp": 1.0}, {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8})
    shapes = []
    for k in range(9):
        face = asdict(random_identity(head, generator)) | {"actions": actions[k % 3]}
        face["changes"] = {name: strength * weight for name, weight in face["changes"].items()}
        shapes.append(head.evaluate(**face))
    features = gradients.features(np.array(shapes))
    ends = flipped_triangles(np.array(shapes), gradients).sum(-1)
    for k in range(len(shapes)):
        for other in range(k):
            between = np.array([(1 - t) * features[k] + t * features[other] for t in (0.25, 0.5, 0.75)])
            found = flipped_triangles(gradients.vertices(between), gradients).sum(-1)
            assert found.max() <= max(ends[k], ends[other]) + allowed * len(gradients.faces)


@pytest.mark.parametrize("angle", [0.0, 1e-7, 1e-4, 2e-4, 0.03, 1.0, 3.0, 5.0])
def test_the_jacobian_of_the_planes_agrees_with_finite_differences(patch_gradients, angle):
    generator = np.random.default_rng(6)
    features = generator.normal(0, 0.2, (patch_gradients.count, FEATURES))
    axes = generator.normal(size=(patch_gradients.count, 3))
    features[:, :3] = angle * axes / np.linalg.norm(axes, axis=1, keepdims=True)
    directions = generator.normal(size=(4, patch_gradients.count, FEATURES))
    planes, jacobian = patch_gradients.planes_jacobian(features, directions)

    def at(values):
        return np.swapaxes(patch_gradients.features_to_maps(values) @ patch_gradients.tangents, -1, -2)

    assert np.allclose(planes, at(features), atol=1e-12)
    step = 1e-5
    for k, direction in enumerate(directions):
        numeric = (at(features + step * direction) - at(features - step * direction)) / (2 * step)
        assert np.abs(jacobian[..., k] - numeric).max() < 1e-7


def test_solve_inverts_the_system_for_any_shape_of_columns(patch_gradients):
    system = (patch_gradients.divergence @ patch_gradients.gradient).toarray()
    right = np.random.default_rng(7).normal(size=(2, patch_gradients.count, 5))
    right -= right.mean(1, keepdims=True)
    solved = patch_gradients.solve(right)
    assert solved.shape == right.shape
    assert np.abs(system @ solved - right).max() < 1e-6


@pytest.mark.parametrize("area", ["exactly none", "none but rounding"])
def test_a_template_with_a_triangle_without_area_is_refused(ball, area):
    vertices, faces = ball[0].copy(), ball[1]
    a, b, c = faces[0]
    vertices[c] = vertices[a] if area == "exactly none" else 0.3 * vertices[a] + 0.7 * vertices[b]
    with pytest.raises(NumericsError, match="without area"):
        DeformationGradients(vertices, faces)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_template_that_is_not_finite_is_refused(ball, value):
    vertices = ball[0].copy()
    vertices[17, 1] = value
    with pytest.raises(NumericsError):
        DeformationGradients(vertices, ball[1])


@pytest.mark.parametrize("where", ["first", "last"])
def test_a_template_with_a_vertex_outside_every_triangle_is_refused(ball, where):
    vertices, faces = ball
    lonely = np.array([[2.0, 0.0, 0.0]])
    if where == "first":
        vertices, faces = np.concatenate([lonely, vertices]), faces + 1
    else:
        vertices = np.concatenate([vertices, lonely])
    with pytest.raises(NumericsError, match="outside every triangle"):
        DeformationGradients(vertices, faces)


def test_rotation_matrices_keep_leading_dimensions():
    vectors = np.random.default_rng(8).normal(size=(2, 3, 4, 3))
    matrices = rotation_matrices(vectors)
    assert matrices.shape == (2, 3, 4, 3, 3)
    assert np.allclose(matrices[1, 2, 3], Rotation.from_rotvec(vectors[1, 2, 3]).as_matrix())
