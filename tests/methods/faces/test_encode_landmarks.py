import numpy as np
import pytest

from caricli.methods.faces.encode_landmarks import LandmarkEncoder, landmark_encoder
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks


def test_an_elastic_fit_in_the_terms_of_another_model(pca, intrinsic, seen, strangers):
    points = seen(strangers[0]).points
    face, nme = landmark_encoder(pca, intrinsic).encode(points)
    fit = fit_landmarks(points, intrinsic)
    assert nme == fit.nme and np.array_equal(face.vertices, fit.face.vertices)
    assert face.model_id == pca.model_id and np.allclose(face.latent, pca.encode(face.vertices))
    assert face.camera.scale == fit.face.camera.scale and np.array_equal(face.landmarks, fit.face.landmarks)


def test_the_fitter_s_own_latent_is_kept(intrinsic, seen, strangers):
    points = seen(strangers[0]).points
    face, _ = landmark_encoder(intrinsic, intrinsic).encode(points)
    assert np.array_equal(face.latent, fit_landmarks(points, intrinsic).face.latent)


def test_a_model_of_its_own_fits_within_itself(pca, seen, strangers):
    points = seen(strangers[0]).points
    face, nme = LandmarkEncoder(pca, pca).encode(points)
    fit = fit_landmarks(points, pca, "latent")
    assert nme == fit.nme and np.array_equal(face.latent, fit.face.latent)
    assert np.abs(pca.decode(face.latent) - face.vertices).max() == pytest.approx(0, abs=1e-9)
