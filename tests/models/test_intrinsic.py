import weakref

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel, feature_weights
from caricli.models.kinds import config_class, model_class
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template


@pytest.fixture(scope="module")
def ball_intrinsic(ball_template, balls):
    return IntrinsicModel.train(ball_template, balls, IntrinsicConfig(5))


@pytest.mark.parametrize("shrink", [0.0, 1e-3, 0.5])
def test_a_dense_least_squares_fit_of_the_features_agrees(ball_intrinsic, ball_template, balls, shrink):
    model = ball_intrinsic
    features = ball_template.gradients.features(balls[0] + np.random.default_rng(0).normal(0, 0.01, balls[0].shape))
    root = np.sqrt(feature_weights(ball_template))[:, None]
    design = (root * model.basis).reshape(5, -1).T
    right = (root * (features - model.mean)).ravel()
    design = np.concatenate([design, np.sqrt(shrink) * np.eye(5)])
    expected = np.linalg.lstsq(design, np.concatenate([right, np.zeros(5)]), rcond=None)[0]
    assert np.abs(model.features_to_latent(features, shrink) - expected).max() < 1e-9


def test_shrinking_shortens_the_latent(ball_intrinsic, ball_template, balls):
    features = ball_template.gradients.features(balls[0])
    lengths = [np.linalg.norm(ball_intrinsic.features_to_latent(features, s)) for s in (0.0, 1e-3, 1e-1, 1e3)]
    assert lengths[0] > lengths[1] > lengths[2] > lengths[3]
    assert lengths[3] < 0.01 * lengths[0]


def test_features_of_latents_come_back_exactly(intrinsic):
    latents = np.random.default_rng(1).normal(size=(2, 3, len(intrinsic.basis)))
    assert np.abs(intrinsic.features_to_latent(intrinsic.features(latents)) - latents).max() < 1e-9


def test_the_residual_brings_back_the_very_shape_up_to_where_it_is(intrinsic, people):
    """What a latent cannot say is kept beside it, so that a face keeps its likeness."""
    features = intrinsic.template.gradients.features(people[:3])
    latents = intrinsic.features_to_latent(features)
    shapes = intrinsic.decode(latents, features - intrinsic.features(latents))
    centred = [s - s.mean(1, keepdims=True) for s in (shapes, people[:3])]
    assert np.abs(centred[0] - centred[1]).max() < 1e-7
    assert np.allclose(shapes.mean(1), intrinsic.decode(latents).mean(1), atol=1e-9)
    single = intrinsic.decode(latents[2], features[2] - intrinsic.features(latents[2]))
    assert np.abs(single - shapes[2]).max() < 1e-9


def test_one_residual_serves_a_whole_batch(ball_intrinsic):
    residual = np.random.default_rng(2).normal(0, 0.05, (300, 9))
    latents = np.random.default_rng(3).normal(size=(2, 5))
    shapes = ball_intrinsic.decode(latents, residual)
    assert np.allclose(shapes[1], ball_intrinsic.decode(latents[1], residual), atol=1e-12)


def test_the_offset_predicts_where_the_shape_is(ball_intrinsic, balls):
    predicted = ball_intrinsic.decode(ball_intrinsic.encode(balls)).mean(1)
    spread = np.linalg.norm(balls.mean(1) - balls.mean((0, 1)), axis=1).mean()
    assert np.linalg.norm(predicted - balls.mean(1), axis=1).mean() < 0.2 * spread


def test_the_latent_does_not_see_a_translation(intrinsic, people):
    assert np.abs(intrinsic.encode(people[0] + [0.1, 0.2, -0.3]) - intrinsic.encode(people[0])).max() < 1e-9


def test_it_extrapolates_turns_where_positions_tear(ball_template):
    """A twist five times as strong as any that was learnt."""
    vertices = ball_template.vertices * [0.3, 1.0, 0.3]

    def twisted(angle):
        return Rotation.from_rotvec(np.outer(angle * vertices[:, 1], [0, 1, 0])).apply(vertices)

    shapes = np.array([twisted(angle) for angle in np.linspace(-0.3, 0.3, 13)])
    template = ball_template.with_vertices(vertices)
    found = {}
    for kind in ("intrinsic", "pca"):
        model = model_class(kind).train(template, shapes, config_class(kind)(1))
        found[kind] = model.decode(5 * model.encode(twisted(0.3)))
    error = {kind: np.abs(shape - shape.mean(0) - twisted(1.5)).max() for kind, shape in found.items()}
    assert error["intrinsic"] < 0.05 < 0.1 < error["pca"]
    assert not flipped_triangles(found["intrinsic"], template.gradients).any()


def test_anchors_are_prepared_for_every_landmark_and_jaw_path(intrinsic):
    expected = intrinsic.template.annotation.anchor_ids()
    assert np.array_equal(intrinsic.template.anchors.points, expected)
    assert intrinsic.template.anchors is intrinsic.template.anchors


def test_weights_are_shares_of_the_area(ball_template):
    weights = feature_weights(ball_template)
    assert weights.sum() == pytest.approx(1.0)
    assert (weights > 0).all() and weights.max() < 3 / 300


def test_components_stay_where_they_belong(head_template, people, ball):
    socket = head_template.annotation.regions["eye_socket_left"]
    count = len(head_template.vertices)

    def with_eye(shape):
        # How far forward an eye lies is its own affair, which no feature holds.
        eye = shape[socket].mean(0) + 0.015 * ball[0] + [0, 0, 0.1 * (shape[33, 0] - shape[700, 0])]
        return np.concatenate([shape, eye])

    polygons = np.concatenate([head_template.polygons, np.column_stack([ball[1] + count, np.full(len(ball[1]), -1)])])
    template = Template(with_eye(head_template.vertices), polygons, annotation=head_template.annotation)
    shapes = np.array([with_eye(shape) for shape in people])
    model = IntrinsicModel.train(template, shapes, IntrinsicConfig(dimension=39))
    assert model.offset.shape == (40, 6)
    latents = model.encode(shapes[:3])
    decoded = model.decode(latents)
    assert np.linalg.norm(decoded - shapes[:3], axis=2).max() < 2e-3
    back = IntrinsicModel.from_tensors(template, model.tensors())
    assert np.abs(back.decode(latents) - decoded).max() < 1e-3
    points = np.array([2, count + 7, 30])
    positions, jacobian = model.points_jacobian(latents[0], points)
    assert np.abs(positions - decoded[0, points]).max() < 1e-9
    np.testing.assert_allclose(model.decode_points(latents[0], points), positions, atol=1e-12)
    step = 1e-5 * np.eye(39)[4]
    slow = (model.decode(latents[0] + step) - model.decode(latents[0] - step))[points] / 2e-5
    np.testing.assert_allclose(jacobian[..., 4], slow, atol=1e-7)


def test_features_are_kept_for_the_last_two_latents_alone_and_are_not_written_to(ball_intrinsic):
    latents = np.random.default_rng(5).normal(size=(4, 5))
    first = weakref.ref(ball_intrinsic.features(latents[0]))
    second = ball_intrinsic.features(latents[1])
    assert ball_intrinsic.features(latents[1]) is second
    with pytest.raises(ValueError, match="read-only"):
        second[0, 0] = 1
    for latent in latents[2:]:
        ball_intrinsic.features(latent)
    assert first() is None


def test_the_tangent_is_that_of_its_own_basis_and_its_own_points(ball_intrinsic, ball_template, tmp_path, monkeypatch):
    """Where it is kept in the user's cache, too."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("caricli.io.kept.QUICK", 0)
    model = ball_intrinsic
    other = IntrinsicModel(ball_template, model.mean, 2 * model.basis[::-1], model.offset)
    source = {"ibug68": list(range(1, 273, 4))}
    elsewhere = Template(
        ball_template.vertices, ball_template.faces, annotation=parse_annotation(source, 300, "elsewhere")
    )
    third = IntrinsicModel(elsewhere, model.mean, model.basis, model.offset)
    moved = IntrinsicModel(ball_template, model.mean, model.basis, model.offset + 1)
    for each in (IntrinsicModel(ball_template, model.mean, model.basis, model.offset), other, third, moved):
        points = each.template.annotation.anchor_ids()
        np.testing.assert_allclose(each.tangent, each.points_jacobian(np.zeros(5), points)[1], atol=1e-9)


def test_a_file_whose_template_has_no_area_is_named(ball_intrinsic):
    tensors, metadata = model_to_checkpoint(ball_intrinsic, None)
    flat = tensors["template.vertices"].copy()
    flat[tensors["template.faces"][0]] = flat[0]
    with pytest.raises(NumericsError, match="^flat.safetensors: the template has triangles without area"):
        model_from_checkpoint({**tensors, "template.vertices": flat}, metadata, "flat.safetensors")
