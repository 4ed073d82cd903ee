"""What every shape model must do, whatever it is made of; what those of principal components must do besides."""

import numpy as np
import pytest
import scipy.sparse as sp

from caricli.errors import NumericsError


def latents(model, count, seed=0):
    return model.prior.sample(np.random.default_rng(seed), count)


def test_encode_undoes_decode(model, tested):
    given = latents(model, 6)
    found = model.encode(model.decode(given))
    assert np.sqrt(((found - given) ** 2).mean()) < tested.again


def test_a_latent_that_is_a_shape_is_found_again_exactly(model, people):
    """Encoding a second time gives the same latent, up to what the features of no shape lose."""
    once = model.encode(people[:5])
    twice = model.encode(model.decode(once))
    assert np.sqrt(((twice - once) ** 2).mean()) < 0.05


def test_leading_dimensions_are_batches(model):
    given = latents(model, 6).reshape(2, 3, -1)
    shapes = model.decode(given)
    assert shapes.shape == (2, 3, *model.template.vertices.shape)
    assert np.allclose(shapes[1, 2], model.decode(given[1, 2]), atol=1e-10)
    found = model.encode(shapes)
    assert found.shape == given.shape
    assert np.allclose(found[1, 2], model.encode(shapes[1, 2]), atol=1e-8)
    assert model.decode(given[:0]).shape == (0, 3, *model.template.vertices.shape)


def test_decode_points_agrees_with_decode(model):
    points = model.template.annotation.anchor_ids()
    for latent in latents(model, 3):
        positions, jacobian = model.points_jacobian(latent, points)
        assert positions.shape == (len(points), 3)
        assert jacobian.shape == (len(points), 3, len(latent))
        assert np.abs(positions - model.decode(latent)[points]).max() < 1e-9
        assert np.abs(model.decode_points(latent, points) - positions).max() < 1e-12


def test_decode_points_takes_other_points_in_any_order_after_that(model):
    latent = latents(model, 1)[0]
    shape = model.decode(latent)
    # The bytes of the second and third are the same, though they name other vertices.
    for points in (np.array([7, 3, 4000]), np.array([9]), np.array([9, 0], np.int32), [5, 6]):
        positions, jacobian = model.points_jacobian(latent, points)
        assert np.abs(positions - shape[points]).max() < 1e-9
        assert len(jacobian) == len(points)


@pytest.mark.parametrize("size", [0.0, 1.0, 3.0])
def test_the_jacobian_agrees_with_finite_differences(model, size):
    points = model.template.annotation.landmarks[::9]
    latent = size * latents(model, 1, seed=1)[0]
    _, jacobian = model.points_jacobian(latent, points)
    step = 1e-4
    for k, direction in enumerate(np.eye(len(latent))):
        ends = [model.decode_points(latent + sign * step * direction, points) for sign in (1, -1)]
        assert np.abs(jacobian[..., k] - (ends[0] - ends[1]) / (2 * step)).max() < 1e-8


def test_the_training_latents_are_white(model, tested, people):
    whitened = model.prior.whiten(model.encode(people))
    assert np.abs(whitened.mean(0)).max() < tested.white
    assert np.abs(np.cov(whitened.T) - np.eye(whitened.shape[1])).max() < 10 * tested.white


def test_typical_faces_have_an_rms_of_about_one(model, people):
    rms = model.prior.rms(model.encode(people))
    assert rms.shape == (len(people),)
    assert 0.9 < np.sqrt((rms**2).mean()) < 1.1


def test_inputs_are_left_alone(model, people):
    given, shapes = latents(model, 2), people[:2].copy()
    before = given.copy()
    model.decode(given)
    model.points_jacobian(given[0], [1, 2])
    model.encode(shapes)
    assert np.array_equal(given, before) and np.array_equal(shapes, people[:2])


def test_training_twice_gives_the_same_tensors(ball_model, train_balls, balls):
    again = train_balls(balls, 5).tensors()
    assert all(np.array_equal(value, again[name]) for name, value in ball_model.tensors().items())


def test_shapes_that_are_all_the_same_are_refused(train_balls, balls):
    with pytest.raises(NumericsError, match="differ"):
        train_balls(np.repeat(balls[:1], 4, axis=0), 3)


def test_places_between_vertices_are_decoded_in_batches(model):
    given, count = latents(model, 6).reshape(2, 3, -1), len(model.template.vertices)
    shapes = model.decode(given)
    assert np.abs(model.decode_on(given, sp.identity(count, format="csr")) - shapes).max() < 1e-9
    rows, columns = [0, 0, 1, 2, 2, 2], [5, 6, 4000, 7, 8, 9]
    weights = sp.csr_matrix(([0.5, 0.5, 1.0, 0.2, 0.3, 0.5], (rows, columns)), shape=(3, count))
    found = model.decode_on(given, weights)
    assert found.shape == (2, 3, 3, 3)
    assert np.abs(found - np.einsum("kv,...vc->...kc", weights.toarray(), shapes)).max() < 1e-9


def test_training_shapes_are_rebuilt_better_than_by_their_mean(principal_model, people):
    rebuilt = principal_model.decode(principal_model.encode(people))
    assert rebuilt.shape == people.shape
    error = np.linalg.norm(rebuilt - people, axis=-1).mean()
    spread = np.linalg.norm(people - people.mean(0), axis=-1).mean()
    assert error < 0.5 * spread
    # Also where in space the shape is, not only its form.
    away = np.linalg.norm(people.mean(1) - people.mean((0, 1)), axis=1).mean()
    assert np.linalg.norm(rebuilt.mean(1) - people.mean(1), axis=1).mean() < 0.5 * away


def test_samples_vary_as_the_training_shapes_do(principal_model, people):
    landmarks = principal_model.template.annotation.landmarks
    sampled = principal_model.decode(latents(principal_model, 60, seed=2))[:, landmarks]
    assert np.isfinite(sampled).all()
    spread, expected = (np.linalg.norm(s - s.mean(0), axis=-1).mean() for s in (sampled, people[:, landmarks]))
    assert 0.7 < spread / expected < 1.3
    assert np.linalg.norm(sampled.mean(0) - people[:, landmarks].mean(0), axis=-1).max() < expected


def test_no_more_dimensions_than_shapes_allow(train_principal, balls):
    small = train_principal(balls[:4], 128)
    assert len(small.prior.mean) == 3
    assert np.isfinite(small.decode(np.ones(3))).all()


def test_shapes_that_come_twice_train_a_model_that_keeps_them(train_principal, balls):
    shapes = np.concatenate([balls[:4], balls[:3]])
    trained = train_principal(shapes, 128)
    assert len(trained.prior.mean) == 3
    assert np.abs(trained.encode(shapes)).max() < 10
    forms = [s - s.mean(1, keepdims=True) for s in (trained.decode(trained.encode(shapes)), shapes)]
    assert np.abs(forms[0] - forms[1]).max() < 1e-3
