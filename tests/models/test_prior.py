import numpy as np
import pytest

from caricli.models.prior import Prior

GENERATOR = np.random.default_rng(0)
LATENTS = GENERATOR.normal(size=(400, 5)) @ GENERATOR.normal(size=(5, 5)) + GENERATOR.normal(size=5)


def test_whitened_training_latents_are_white():
    whitened = Prior.of(LATENTS).whiten(LATENTS)
    assert np.abs(whitened.mean(0)).max() < 1e-9
    assert np.abs(np.cov(whitened.T) - np.eye(5)).max() < 1e-3


def test_colour_undoes_whiten_for_any_leading_dimensions():
    prior, latents = Prior.of(LATENTS), LATENTS[:12].reshape(3, 4, 5)
    whitened = prior.whiten(latents)
    assert whitened.shape == latents.shape
    assert np.allclose(prior.colour(whitened), latents)
    assert np.allclose(whitened[2, 1], prior.whiten(latents[2, 1]))


def test_whitening_factors_no_matrix(monkeypatch):
    prior = Prior.of(LATENTS)
    monkeypatch.setattr(np.linalg, "solve", pytest.fail)
    assert prior.whiten(LATENTS).shape == LATENTS.shape and prior.whiten(LATENTS[:0]).shape == (0, 5)


def test_rms_is_the_mahalanobis_distance_over_the_root_of_the_dimensions():
    prior = Prior.of(LATENTS, ridge=0.0)
    centred = LATENTS - LATENTS.mean(0)
    distance = np.einsum("ni,ij,nj->n", centred, np.linalg.inv(np.cov(LATENTS.T)), centred)
    assert np.allclose(prior.rms(LATENTS), np.sqrt(distance / 5))
    assert prior.rms(prior.mean) == pytest.approx(0.0)


def test_samples_have_the_mean_and_covariance_of_the_training():
    samples = Prior.of(LATENTS).sample(np.random.default_rng(1), 40000)
    assert samples.shape == (40000, 5)
    covariance = np.cov(LATENTS.T)
    deviations = np.sqrt(np.diag(covariance))
    assert (np.abs(samples.mean(0) - LATENTS.mean(0)) < 0.03 * deviations).all()
    assert (np.abs(np.cov(samples.T) - covariance) < 0.04 * np.outer(deviations, deviations)).all()


def test_the_same_generator_gives_the_same_samples():
    prior = Prior.of(LATENTS)
    one, two = (prior.sample(np.random.default_rng(4), 3) for _ in range(2))
    assert np.array_equal(one, two)


def test_the_standard_prior_leaves_latents_as_they_are():
    prior = Prior.standard(5)
    assert np.array_equal(prior.whiten(LATENTS), LATENTS)
    assert np.array_equal(prior.colour(LATENTS), LATENTS)


def test_a_ridge_keeps_latents_that_lie_in_a_plane_finite():
    flat = LATENTS * [1, 1, 1, 1, 0]
    prior = Prior.of(flat)
    assert np.isfinite(prior.whiten(flat)).all()
    assert prior.rms(flat).max() < 10
