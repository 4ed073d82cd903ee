import numpy as np

from caricli.models.pca.model import PcaModel


def test_decode_is_the_mean_plus_the_weighted_basis(pca):
    latent = np.linspace(-1, 1, len(pca.basis))
    expected = pca.mean + sum(z * b for z, b in zip(latent, pca.basis, strict=True))
    assert np.allclose(pca.decode(latent), expected, atol=1e-12)
    assert np.array_equal(pca.decode(np.zeros(len(latent))), pca.mean)


def test_a_dense_decomposition_agrees(pca, people):
    flat = people.reshape(len(people), -1)
    mean = flat.mean(0)
    _, singular, rows = np.linalg.svd(flat - mean, full_matrices=False)
    assert np.abs(pca.mean.ravel() - mean).max() < 1e-9
    deviations = np.linalg.norm(pca.basis.reshape(len(pca.basis), -1), axis=1)
    assert np.allclose(deviations, singular[: len(deviations)] / np.sqrt(len(people) - 1), rtol=1e-3)
    first = pca.basis[0].ravel() / deviations[0]
    assert abs(first @ rows[0]) > 0.9999


def test_encode_is_the_nearest_shape_of_the_space(pca, people):
    shape = people[3] + np.random.default_rng(0).normal(0, 1e-3, people[3].shape)
    design, right = pca.basis.reshape(len(pca.basis), -1).T, (shape - pca.mean).ravel()
    assert np.abs(pca.encode(shape) - np.linalg.lstsq(design, right, rcond=None)[0]).max() < 1e-9


def test_encode_also_holds_for_a_basis_that_is_not_orthogonal(ball_template):
    generator = np.random.default_rng(1)
    basis = generator.normal(size=(3, 300, 3))
    basis[1] += basis[0]
    model = PcaModel(ball_template, ball_template.vertices, basis)
    latents = generator.normal(size=(4, 3))
    assert np.allclose(model.encode(model.decode(latents)), latents)
