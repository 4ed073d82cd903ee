from itertools import islice

import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces import sample_faces as module
from caricli.methods.faces.encode_face import decode_face
from caricli.methods.faces.sample_faces import MAX_FLIPPED, sample_faces


def draw(model, count, seed=0, **options):
    return list(islice(sample_faces(model, np.random.default_rng(seed), **options), count))


@pytest.fixture(scope="module")
def samples(intrinsic):
    return draw(intrinsic, 4, spread=1.3)


def test_faces_are_different_and_hardly_flipped(intrinsic, samples):
    for sample in samples:
        flipped = flipped_triangles(sample.face.vertices, intrinsic.template.gradients).mean()
        assert sample.flipped == flipped <= MAX_FLIPPED
        assert sample.flipped <= sample.flipped_drawn
    apart = np.abs(samples[0].face.vertices - samples[1].face.vertices).max()
    assert apart > 0.005


def test_what_was_mended_is_in_the_residual(intrinsic, samples):
    assert any(sample.flipped < sample.flipped_drawn for sample in samples)
    for sample in samples:
        face = sample.face
        back = decode_face(face, intrinsic, face.shift)
        assert np.abs(back.vertices - face.vertices).max() < 1e-7


def test_the_seed_decides_and_more_faces_begin_alike(pca):
    first, again, other = draw(pca, 1), draw(pca, 2), draw(pca, 1, seed=1)
    assert np.array_equal(first[0].face.vertices, again[0].face.vertices)
    assert not np.array_equal(first[0].face.latent, other[0].face.latent)


def test_spread_scales_the_distance_from_the_mean(pca):
    near, far = (draw(pca, 1, spread=spread)[0].face for spread in (0.5, 1.0))
    assert np.allclose(far.latent - pca.prior.mean, 2 * (near.latent - pca.prior.mean))
    assert np.array_equal(draw(pca, 1, spread=0.0)[0].face.latent, pca.prior.mean)


def test_rejected_draws_are_counted(pca, monkeypatch):
    def flips():
        # As drawn and as mended, of one face after another: two that stay torn, then a whole one.
        for share in (0.1, 0.1, 0.1, 0.1, 0.0, 0.0):
            yield np.full(10, share)

    shares = flips()
    monkeypatch.setattr(module, "flipped_triangles", lambda vertices, gradients: next(shares))
    (sample,) = draw(pca, 1)
    generator = np.random.default_rng(0)
    latents = [generator.normal(size=len(pca.prior.mean)) for _ in range(3)]
    figures = {"prior_rms": sample.face.prior_rms, "flipped": 0.0, "flipped_drawn": 0.0, "rejected": 2}
    assert sample.figures() == figures
    assert sample.rejected == 2 and np.allclose(sample.face.latent, latents[2])


def test_a_model_that_only_tears_is_given_up(pca, monkeypatch):
    monkeypatch.setattr(module, "TRIES", 3)
    monkeypatch.setattr(module, "MAX_FLIPPED", -1)
    with pytest.raises(NumericsError, match="3 random faces in a row .* smaller spread than 1"):
        draw(pca, 1)
